"""Desk of the show: parameters and fades, scenes, cues, launched pads, undo. It may import what `show` may."""
