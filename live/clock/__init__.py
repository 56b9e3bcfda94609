"""Musical time as a value: estimates and taps in, a Timeline out."""
