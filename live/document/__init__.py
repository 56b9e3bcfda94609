"""The show as an edited document."""
