"""Composition of a live show: session, frame loops, launch options, services, windows and films.

May import every layer except `cli`.
"""
