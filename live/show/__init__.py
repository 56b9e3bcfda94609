"""The show simulation: takes events and ticks, yields states and drawing snapshots, plans every measure.

It may import `library` and everything below it.
"""
