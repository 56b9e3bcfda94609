"""Offline work of commands: dances, partners, steps, soak tests and reports.

May import every layer except `cli`.
"""
