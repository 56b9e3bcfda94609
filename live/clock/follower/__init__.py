"""Many sources in, one timeline out."""
