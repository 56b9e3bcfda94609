"""Services that run next to the frame loop: OSC, MIDI, Link, HTTP and phones.

May import every layer except `cli`.
"""
