"""Motion holds skeleton, clips and poses, from a recording or a sketch to joints in the world. It may import `base`."""
