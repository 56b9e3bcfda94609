"""Beats of a recorded dance, found in the motion itself or in claps. It may import what `motion` may."""
