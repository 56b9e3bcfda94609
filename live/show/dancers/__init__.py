"""What each dancer does now: measure, pose, correction, variation. It may import what `show` may."""
