"""Choice of every next step."""
