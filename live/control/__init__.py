"""Inputs and outputs other than pictures: input from people and machines is validated and turned into events.

It may import `motion`, `clock` and `base`, but neither `render` nor the simulation.
"""
