"""Attractors, flows, spreaders."""
