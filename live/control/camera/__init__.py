"""Cameras: people in their pictures, as landmarks. May import what `control` may."""
