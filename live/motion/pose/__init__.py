"""The pose pipeline: samples, blends, foot lock, root warp, hand holds. It may import what `motion` may."""
