"""Tablet layouts generated from the registry of controls. It may import what `control` may."""
