"""Services that run next to the frame loop: OSC, MIDI, Link, HTTP, phones and motion capture.

May import every layer except `cli`.
"""
