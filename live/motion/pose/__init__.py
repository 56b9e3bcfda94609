"""Runtime pose pipeline."""
