"""The patch: its model, reader, checks and search path. It may import what `show` may."""
