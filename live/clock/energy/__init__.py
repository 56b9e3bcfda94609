"""Energy measures loudness and finds build-ups and drops. It may import what `clock` may."""
