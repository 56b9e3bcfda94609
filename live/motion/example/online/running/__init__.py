"""Running: units of which the beginning is seen."""
