"""Entrances bring agents onto the stage and off it, through gates and wings. It may import what `agents` may."""
