"""The clock turns what is heard, tapped or received into musical time: tempo, beat, downbeat and phase.

It may import `base`.
"""
