"""Step library on disk (was steps)."""
