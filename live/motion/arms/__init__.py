"""Hands that are held: two-bone arms brought to a common point between two dancers, in blocks of pairs."""
