"""The machine before a show: its devices, compiled kernels, checks of it and of the venue, start as a service.

May import what app may import.
"""
