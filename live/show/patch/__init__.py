"""The show's patch: model, reader, checks, search path and hot reload. It may import what `show` may."""
