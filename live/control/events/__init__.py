"""Events are what may happen to a show, each a frozen dataclass. It may import what `control` may."""
