"""Tests of a show without people: simulated band and players, fault injection, soak tests, lint for scores.

It may import `supervisor` and everything below it.
"""
