"""Open Sound Control and OSCQuery. May import the same layers as `control`."""
