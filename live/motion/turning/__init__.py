"""Turning on the supporting foot, for all dancers at any moment."""
