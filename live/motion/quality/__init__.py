"""Metrics of motion: beats, feet, smoothness. It may import what `motion` may."""
