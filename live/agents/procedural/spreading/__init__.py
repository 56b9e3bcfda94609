"""Spreading out on the stage (T109)."""
