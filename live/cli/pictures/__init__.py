"""Svg/png drawings."""
