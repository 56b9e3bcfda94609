"""Gates and wings."""
