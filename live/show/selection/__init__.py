"""Step selection: the choice of each dancer's next step. It may import what `show` may."""
