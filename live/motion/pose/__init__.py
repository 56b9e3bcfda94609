"""The pose pipeline: sampling, blending, foot lock, root warp, hand holds. May import what `motion` may."""
