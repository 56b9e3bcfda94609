"""The `base` layer: errors, queues between threads, array types and the drawing snapshot, for use by every layer.

It imports no other layer.
"""
