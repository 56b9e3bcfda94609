"""A partner's dance generated from a leader's by example, frame by frame. It may import what `motion` may."""
