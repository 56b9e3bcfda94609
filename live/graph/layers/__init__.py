"""One layer of a layered search, for all nodes at once."""
