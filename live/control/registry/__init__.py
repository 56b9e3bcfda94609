"""The registry lists every control: its address, arguments, ranges, roles and event.

It may import what `control` may.
"""
