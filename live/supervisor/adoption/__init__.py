"""Adoption of an engine whose supervisor has died by the next supervisor. It may import whatever `supervisor` may."""
