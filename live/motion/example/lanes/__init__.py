"""Lanes: cells that are worked on side by side."""
