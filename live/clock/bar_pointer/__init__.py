"""Bar pointer model: beat and downbeat tracking with a hidden Markov model. It may import what `clock` may."""
