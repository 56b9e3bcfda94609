"""Packed poses as their bytes say them."""
