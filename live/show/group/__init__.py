"""The motion of groups in a show: formations, evolutions, elements. It may import what `show` may."""
