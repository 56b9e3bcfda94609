"""The show's patch: model, reader, search path and hot reload. It may import what `show` may."""
