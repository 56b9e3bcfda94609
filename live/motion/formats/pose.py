"""From BVH channels to joints relative to their parents: offsets, rotation orders, position channels (T164)."""

from typing import Literal

import numpy as np

from live.motion.formats.bvh_kernels import pose_channels
from live.motion.formats.parse import BvhMotion
from live.motion.formats.source_motion import Float64
from live.motion.formats.source_pose import LocalPose


def local_pose(motion: BvhMotion, root_offset: Literal["add", "replace"] = "add") -> LocalPose:
    """Channels as rotations and translations.

    By the format (T164: A = O_A + T_A) position channels are added to OFFSET. Some programs write the whole place
    into them instead: for the root `root_offset` says which it is, for the other joints it is seen from the values
    (whether they lie about zero or about OFFSET).
    """
    base = np.array(motion.offsets, np.float64)
    kinds: list[tuple[int, int]] = []
    for joint, letters in enumerate(motion.channels):
        moves = {"xyz".index(letter): len(kinds) + n for n, letter in enumerate(letters) if letter.islower()}
        if moves:
            axes = list(moves)
            moved = motion.values[:, list(moves.values())]
            if root_offset == "replace" if joint == 0 else _holds_offset(moved, base[joint, axes]):
                base[joint, axes] = 0.0
        kinds += [(joint, "xyzXYZ".index(letter)) for letter in letters]
    frames, joints = motion.frame_count, motion.joint_count
    translation, rotation = np.empty((frames, joints, 3)), np.empty((frames, joints, 4))
    pose_channels(motion.values, np.array(kinds, np.int32).reshape(-1, 2), base, translation, rotation)
    return LocalPose(translation, rotation)


def _holds_offset(moved: Float64, offset: Float64) -> bool:
    """Whether position channels of an inner joint hold the whole offset (then it must not be added again)."""
    return bool(np.median(np.linalg.norm(moved - offset, axis=-1)) < np.median(np.linalg.norm(moved, axis=-1)))
