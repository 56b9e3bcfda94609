"""The journal of a show: writing, reading, replay. It may import what `show` may."""
