"""The snapshot that is drawn, filled from a show's state. It may import what `show` may."""
