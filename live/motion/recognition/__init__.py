"""Recognition of what a seen body does: its steps and gestures. It may import what `motion` may."""
