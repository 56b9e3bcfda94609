"""All events of a show, as frozen dataclasses. May import the same layers as `control`."""
