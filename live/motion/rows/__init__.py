"""Rows of dancers: the arithmetic of poses, one block of dancers at a time."""
