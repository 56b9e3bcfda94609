"""Reaching: an arm brought to a palm that is where it is."""
