"""Onset and beat tracking in audio: features, beat network, aubio. It may import what `clock` may."""
