"""Agents: dancers as points on the floor, their goals, steering behaviours and the fixed simulation tick.

This package may import `motion`, `clock` and `base`.
"""
