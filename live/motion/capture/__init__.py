"""Poses of people who are captured live, made whole and smooth. It may import what `motion` may."""
