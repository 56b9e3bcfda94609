"""Formations are shapes on the floor and the places of dancers in them. It may import what `agents` may."""
