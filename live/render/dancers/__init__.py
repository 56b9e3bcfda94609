"""Dancers in many: instances, styles, trails, particles. It may import what `render` may."""
