"""Serialization of a show's state: kinds, encoder, decoder and checks. It may import what `show` may."""
