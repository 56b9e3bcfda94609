"""The thesis' way of avoiding each other: two distances (T108)."""
