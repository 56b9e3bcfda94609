"""The choice of every dancer's next step. It may import what `show` may."""
