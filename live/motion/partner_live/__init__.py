"""Example-based partner, online."""
