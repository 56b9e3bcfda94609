"""Operator's web page and its server. It may import what `control` may."""
