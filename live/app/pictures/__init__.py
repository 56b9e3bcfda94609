"""Drawings that commands write, as SVG or PNG: formations, graphs, reach, scores, journals, contact sheets.

It may import every layer but `cli`.
"""
