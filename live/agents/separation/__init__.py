"""Separation predicts collisions and keeps the paths of dancers apart. It may import what `agents` may."""
