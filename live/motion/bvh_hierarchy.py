"""Moved: see live.motion.file_error."""

from live.motion.file_error import MotionFileError as MotionFileError
