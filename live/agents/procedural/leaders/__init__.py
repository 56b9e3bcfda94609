"""Dancers who follow, pursue or evade another (T082)."""
