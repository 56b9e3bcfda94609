"""Cloth, hair and ribbons that move by themselves: garments on a dancer's body, simulated at ticks."""
