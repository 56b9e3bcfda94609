"""Edits of clips, offline: time warp, amplitude, turns, mirrors. It may import what `motion` may."""
