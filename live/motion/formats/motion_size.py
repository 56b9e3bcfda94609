"""How much motion a file may hold, so that reading it takes 64 MB and 20 times its length at most."""

from typing import Final

from live.motion.formats.file_error import MotionFileError

VALUE_LIMIT: Final = 10_000_000
"""Numbers in the motion part of a file at most: ten minutes of 43 joints at 120 frames per second."""
JOINT_BYTES: Final = 56
"""Memory that a joint takes in each frame: a translation and a quaternion in float64."""
FREE_BYTES: Final = 32_000_000
"""Memory for joints, beside eight times that of the file: a few channels could ask for any number of joints."""


def refuse_too_large(file: str, frames: int, joints: int, channels: int, file_bytes: int) -> None:
    """Raise MotionFileError if joints that hardly have channels would take memory out of all proportion."""
    if frames * joints * JOINT_BYTES > FREE_BYTES + 8 * file_bytes:
        problem = f"{frames} frames of {joints} joints with {channels} channels in all"
        raise MotionFileError(file, None, problem, "channels for most joints expected, or fewer frames")
