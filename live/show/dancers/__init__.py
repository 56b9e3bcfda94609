"""State of each dancer: measure, pose, root correction and variation. It may import what `show` may."""
