"""A partner's dance generated from a leader's by example, offline (Hsu et al.). It may import what `motion` may."""
