"""Group motion of a show: formations, evolutions and elements. It may import what `show` may."""
