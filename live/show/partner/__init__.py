"""Partners on stage."""
