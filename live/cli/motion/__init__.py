"""Commands about motion files: BVH, capture, characters, export and synchronisation. It may import every layer."""
