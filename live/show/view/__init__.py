"""The drawing snapshot of a show, its scene and debug overlay. It may import what `show` may."""
