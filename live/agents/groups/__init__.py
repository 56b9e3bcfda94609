"""Groups say which dancers are meant: a roster, and expressions over it. It may import what `agents` may."""
