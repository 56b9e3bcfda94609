"""Readers and writers of motion files: BVH, glTF, AMASS. It may import what `motion` may."""
