"""Desk of the show: parameters and fades, scenes, cues, undo. It may import what `show` may."""
