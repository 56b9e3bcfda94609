"""Base holds what every layer may use: errors, queues between threads, array types, the drawing snapshot.

It imports no other layer.
"""
