"""Where held and free feet are between two ticks."""
