"""Audio features, onset and beat networks."""
