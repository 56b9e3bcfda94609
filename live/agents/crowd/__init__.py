"""The crowd: steering of all agents in one pass over neighbours, with two ways of avoidance (T080-T083, T108)."""
