"""BVH files: parsed as they are written (`parse_bvh`), and as the motion that they mean (`source_of_bvh`)."""

from live.motion.bvh.parse import BvhMotion, parse_bvh
from live.motion.bvh.source import source_of_bvh
from live.motion.file_error import MotionFileError

__all__ = ["BvhMotion", "MotionFileError", "parse_bvh", "source_of_bvh"]
