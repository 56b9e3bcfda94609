"""Partners on the stage, rehearsed or answered live. It may import what `show` may."""
