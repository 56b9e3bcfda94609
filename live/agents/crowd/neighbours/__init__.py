"""Neighbours: what the others ask of an agent, all in one pass."""
