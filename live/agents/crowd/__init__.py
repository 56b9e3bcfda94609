"""One tick of the crowd: spatial grid, neighbours, acceleration, contacts and stage bounds.

It may import what `agents` may, and no other room but its kernels.
"""
