"""Goals: target places and way points of agents. This package may import what `agents` may."""
