"""The stages of a frame, in the order of `live/show/frame.py`. They may import what `show` may."""
