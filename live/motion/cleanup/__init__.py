"""Detection and repair of motion capture faults. May import what `motion` may."""
