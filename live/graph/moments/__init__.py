"""Moments: where bodies are and how they move at every quarter of a beat, so that one clip can be left for another."""
