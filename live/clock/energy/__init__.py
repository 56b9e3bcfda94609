"""Loudness measurement and detection of build-ups and drops. It may import what `clock` may."""
