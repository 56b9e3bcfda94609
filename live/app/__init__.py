"""The app composes a live show: session, frame loops, launch options, and what a window or a film needs.

It may import every layer but `cli`.
"""
