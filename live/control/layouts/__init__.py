"""Layouts for tablets, made from the registry of controls. It may import what `control` may."""
