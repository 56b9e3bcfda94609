"""Elements act on agents: attractors, repulsors, spreaders, crossings and flow fields.

It may import what `agents` may.
"""
