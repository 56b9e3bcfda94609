"""Services run beside the frame loop: OSC, MIDI, Link, HTTP, phones, capture and lamps.

It may import every layer but `cli`.
"""
