"""Offline work of commands: films, dances, partners, steps, soak tests and reports.

May import every layer except `cli`.
"""
