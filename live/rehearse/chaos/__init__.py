"""Chaos tests: faults in the program itself (exceptions in ticks, killed processes, full disks) and checks of recovery.

It may import what `rehearse` may.
"""
