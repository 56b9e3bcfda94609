"""Paths, wandering, flocks and spreaders: what moves a dancer where nothing is near (T082, T109)."""
