"""Captured performers on stage."""
