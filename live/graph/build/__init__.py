"""Metrics and edges."""
