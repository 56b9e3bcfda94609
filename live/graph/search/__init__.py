"""Sequences and paths, offline."""
