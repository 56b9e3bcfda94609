"""The follower makes one timeline of many clock sources, and corrects its phase without a jump.

It may import what `clock` may.
"""
