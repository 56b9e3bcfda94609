"""Snapshot for drawing."""
