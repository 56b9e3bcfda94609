"""Chaos breaks the program itself: exceptions in ticks, kills, full disks, and counts what happens.

It may import what `rehearse` may.
"""
