"""Patch model, reader, checks."""
