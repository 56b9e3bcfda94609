"""Venue settings: devices, delays, outputs and network of a hall. It may import what `show` may."""
