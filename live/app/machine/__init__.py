"""Checks of the machine and of the venue before a show, its devices, and its start as a service.

May import what app may import.
"""
