"""Commands for motion files: BVH, capture, characters, export and synchronisation. They may import every layer."""
