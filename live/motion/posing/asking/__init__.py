"""Asking: which samples of which clips, where, and how much of each, for everybody at one moment of the measure."""
