"""Quaternions one by one, for captured bodies."""
