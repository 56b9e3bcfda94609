"""Cleanup finds and mends faults of motion capture. It may import what `motion` may."""
