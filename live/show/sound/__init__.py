"""Sound of a show: film soundtrack, click track, Ableton Link, clock events. It may import what `show` may."""
