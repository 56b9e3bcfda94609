"""Simulation tick of the crowd: spatial grid, neighbours, acceleration, contacts and stage bounds.

This package may import what `agents` may, and of the other packages in `agents` only kernels.
"""
