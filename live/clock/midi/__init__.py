"""Midi beat clock and time code."""
