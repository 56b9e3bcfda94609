"""Ableton link."""
