"""Magnitudes of a real signal's spectrum, for any length without large prime factors, without allocating anything."""
