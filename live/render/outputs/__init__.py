"""Outputs: the picture on one or several projectors, bent to what it falls on."""
