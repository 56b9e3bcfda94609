"""Places of single units on an input, for up-sampling (H012)."""
