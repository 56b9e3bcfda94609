"""Ableton Link: tempo and beat shared with other programs. May import the same layers as `control`."""
