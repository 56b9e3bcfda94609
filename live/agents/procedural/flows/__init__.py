"""Flow fields (T082)."""
