"""Skeleton, clips and poses: from recordings and sketches to joints in the world."""
