"""Motion editing tools: pure functions on arrays and clips, each of which returns a new clip and changes none."""
