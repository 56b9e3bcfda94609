"""Live captured performers on the stage. It may import what `show` may."""
