"""Everything beside the loop."""
