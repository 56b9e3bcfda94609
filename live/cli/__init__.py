"""Command line: one module for each command, which parses options and calls the code in live.app.

It may import every layer.
"""
