"""Recognition of what a seen body does: its steps. It may import what `motion` may."""
