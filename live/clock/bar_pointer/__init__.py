"""The bar pointer tracks beat and downbeat with a hidden Markov model. It may import what `clock` may."""
