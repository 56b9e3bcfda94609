"""Bounds: stage edges, walls and obstacles."""
