"""Partners on the stage: followers answer leaders live. It may import what `show` may."""
