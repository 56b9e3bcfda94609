"""Passes of a picture, one file each. It may import what `render` may."""
