"""The follower derives one timeline from many clock sources and corrects its phase without jumps.

It may import what `clock` may.
"""
