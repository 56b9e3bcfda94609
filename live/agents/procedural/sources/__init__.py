"""Attractors and repulsors of any shape (T105, T106)."""
