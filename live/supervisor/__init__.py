"""The supervisor starts the processes of a show, watches them, and lets another engine go on.

It may import `show` and everything below it.
"""
