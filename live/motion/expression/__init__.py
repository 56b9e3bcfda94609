"""Faces, hands and feet: what drawn bodies do beyond the joints of the steps."""
