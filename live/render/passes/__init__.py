"""Render passes, one file for each kind. It may import what `render` may."""
