"""The step library on disk: motion files, what is written about them, caches.

It may import `graph`, `agents`, `control`, `render` and what these may.
"""
