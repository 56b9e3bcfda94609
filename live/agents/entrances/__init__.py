"""Entrances and exits of agents through gates and wings. This package may import what `agents` may."""
