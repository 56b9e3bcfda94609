"""The point-cloud metric (K001-K003): weights, flattened clouds, and all pairs of windows that are near each other."""
