"""The state of a show as data: kinds, encoder, decoder, checks. It may import what `show` may."""
