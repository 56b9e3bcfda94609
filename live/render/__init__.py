"""Rendering of the stage snapshot from `base`, independent of the rest of the show.

It may import `motion`, `clock` and `base`.
"""
