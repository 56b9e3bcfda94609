"""Evolutions plan the motion of a group from one formation to the next, beat by beat.

It may import what `agents` may.
"""
