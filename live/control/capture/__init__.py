"""Vmc and posistagenet."""
