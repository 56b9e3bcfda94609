"""The command line: one file for each command, which reads options and calls what does the work.

It may import every layer.
"""
