"""The stages of a tick, in the order of `live/show/frame.py`. They may import what `show` may."""
