"""Agents are the dancers as points on the floor: what they want, how they are steered, and one fixed tick for all.

It may import `motion`, `clock` and `base`.
"""
