"""Generated body mesh."""
