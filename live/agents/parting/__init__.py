"""Parting: places that lie too near to each other are moved apart."""
