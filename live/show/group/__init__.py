"""Group motion of a show."""
