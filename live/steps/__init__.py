"""The library of steps on disk: motion files, what people write about them, sketches, and the caches beside them."""
