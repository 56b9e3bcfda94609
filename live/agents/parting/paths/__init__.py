"""Paths through a measure that lead too near to each other are moved apart before anybody goes them."""
