"""glTF 2.0, GLB and VRM: animations read as recordings, clips written as files that other programs open."""

from live.motion.gltf.reader import parse_gltf

__all__ = ["parse_gltf"]
