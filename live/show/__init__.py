"""The show: events and ticks in, states and snapshots out; it decides what happens in which measure.

It may import `library` and everything below it.
"""
