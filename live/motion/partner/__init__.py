"""Example-based partner, offline."""
