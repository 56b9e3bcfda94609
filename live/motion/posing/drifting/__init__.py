"""Drifting: the warp over the whole sequence, of all dancers or some, in one pass."""
