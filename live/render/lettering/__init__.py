"""Letters: a glyph atlas of one size for small text, and distance fields for letters of any size."""
