"""Registry of all controls: address, arguments, ranges, roles and event. May import the same layers as `control`."""
