"""The step library on disk: motion files, their TOML descriptions, and caches.

It may import `graph`, `agents`, `control`, `render` and what these may.
"""
