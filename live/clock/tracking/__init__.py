"""Tracking finds onsets and beats in sound: features, beat network, aubio. It may import what `clock` may."""
