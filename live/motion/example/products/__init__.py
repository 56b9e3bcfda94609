"""Products of an input with what is recorded (K003)."""
