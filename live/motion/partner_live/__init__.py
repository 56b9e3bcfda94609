"""Example-based partner synthesis live: a follower generated frame by frame. May import what `motion` may."""
