"""MIDI beat clock: decoding of pulses to tempo and position, and generation of pulses.

It may import what `clock` may.
"""
