"""Formations: shapes on the floor and the places of dancers in them. This package may import what `agents` may."""
