"""Rehearsal without people: a made-up band, players and phones, faults, long runs, warnings about scores.

It may import `supervisor` and everything below it.
"""
