"""Outputs to projectors: corner pin, mesh, soft edge, masks, test cards, flash limit.

It may import what `render` may.
"""
