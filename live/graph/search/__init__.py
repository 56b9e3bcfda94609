"""Searches for sequences and paths through the graph, offline. It may import what `graph` may."""
