"""Sketches are steps written as text, with key poses and timing. It may import what `motion` may."""
