"""Crossing over a line (T110)."""
