"""Elements: force fields that act on agents, such as attractors, repulsors, spreaders, crossings and flow fields.

This package may import what `agents` may.
"""
