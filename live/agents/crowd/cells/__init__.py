"""Cells: who stands near whom, by a counting sort."""
