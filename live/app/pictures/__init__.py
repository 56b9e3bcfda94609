"""Drawings that commands write, as SVG or PNG: formations, graphs, reach, scores, journals, contact sheets.

May import every layer except `cli`.
"""
