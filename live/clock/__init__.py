"""The `clock` layer: musical time (tempo, beat, downbeat and phase) from audio, taps or received clock signals.

It may import `base`.
"""
