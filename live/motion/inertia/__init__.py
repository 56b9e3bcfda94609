"""Inertia: a dancer who leaves one clip for another at once keeps her pose and speed, and lets go of them smoothly."""
