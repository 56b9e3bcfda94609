"""Sound of a film, click."""
