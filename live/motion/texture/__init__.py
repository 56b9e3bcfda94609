"""Texture: sketched motion gets the detail of recordings (Pullen & Bregler). It may import what `motion` may."""
