"""Leading: who wears a captured pose stands where it stands, and her plans with her."""
