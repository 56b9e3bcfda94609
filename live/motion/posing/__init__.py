"""The pose pipeline: from clips, weights and edits to joints in the world, for all dancers, in blocks."""
