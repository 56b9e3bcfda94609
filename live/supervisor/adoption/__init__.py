"""Adoption: the next supervisor takes over an engine whose own has died. It may import what `supervisor` may."""
