"""Readers and writers of motion files: BVH, ASF/AMC, glTF, AMASS. It may import what `motion` may."""
