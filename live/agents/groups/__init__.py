"""Groups: the roster and expressions that select dancers. This package may import what `agents` may."""
