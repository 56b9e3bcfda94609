"""The venue: what is true of a hall and not of a show. It may import what `show` may."""
