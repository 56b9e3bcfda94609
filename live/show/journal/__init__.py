"""The journal of a show: writer, reader, replay. It may import what `show` may."""
