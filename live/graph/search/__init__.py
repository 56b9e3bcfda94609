"""Offline searches for sequences and paths through the graph. It may import what `graph` may."""
