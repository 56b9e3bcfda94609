"""Retargeting of recorded skeletons to the engine's. May import what `motion` may."""
