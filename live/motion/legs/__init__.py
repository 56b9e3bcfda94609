"""Feet that stay where they stand: two-bone legs, foot lock and floor, in blocks of dancers."""
