"""MIDI beat clock and MIDI time code: pulses in, tempo and position out, and the other way round.

It may import what `clock` may.
"""
