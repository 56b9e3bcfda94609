"""Render draws the stage snapshot of `base` and knows nothing else of a show.

It may import `motion`, `clock` and `base`.
"""
