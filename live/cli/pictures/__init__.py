"""Drawings of the command line, as SVG or PNG. It may import every layer."""
