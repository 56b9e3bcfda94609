"""Services that run next to the frame loop: OSC, MIDI, Link, HTTP, phones, motion capture and DMX.

May import every layer except `cli`.
"""
