"""Remembered poses, found by when they came."""
