"""Evolutions: who goes where, on which way, facing where, exactly with the measures (thesis 4.2 and 4.3)."""
