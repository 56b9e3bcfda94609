"""Retargeting of foreign skeletons onto ours. It may import what `motion` may."""
