"""Commands for motion files: BVH, characters, export and synchronisation. They may import every layer."""
