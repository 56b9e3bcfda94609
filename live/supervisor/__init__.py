"""Process supervision: starts the processes of a show, watches them and fails over to another engine.

It may import `show` and everything below it.
"""
