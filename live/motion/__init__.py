"""Skeleton, clips and poses: from a recording or a sketch to joints in world space. May import `base`."""
