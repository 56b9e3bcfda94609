"""Bvh, asf/amc, gltf, amass readers and writers."""
