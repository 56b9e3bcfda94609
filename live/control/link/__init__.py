"""Ableton Link: tempo and beat shared with other programs. It may import what `control` may."""
