"""From BVH channels to joints relative to their parents: offsets, rotation orders, position channels (T164)."""

from typing import Literal

import numpy as np

from live.motion.bvh.parse import BvhMotion
from live.motion.euler import euler_to_quaternion
from live.motion.source_motion import Float64
from live.motion.source_pose import LocalPose


def local_pose(motion: BvhMotion, root_offset: Literal["add", "replace"] = "add") -> LocalPose:
    """Channels as rotations and translations.

    By the format (T164: A = O_A + T_A) position channels are added to OFFSET. Some programs write the whole place
    into them instead: for the root `root_offset` says which it is, for the other joints it is seen from the values
    (whether they lie about zero or about OFFSET).
    """
    frames, joints = motion.frame_count, motion.joint_count
    rotation = np.zeros((frames, joints, 4))
    rotation[..., 0] = 1.0
    translation = np.broadcast_to(motion.offsets, (frames, joints, 3)).copy()
    columns: dict[str, list[tuple[int, list[int]]]] = {}
    first = 0
    for joint, letters in enumerate(motion.channels):
        turns = [first + place for place, letter in enumerate(letters) if letter.isupper()]
        columns.setdefault("".join(filter(str.isupper, letters)), []).append((joint, turns))
        moves = {"xyz".index(letter): first + place for place, letter in enumerate(letters) if letter.islower()}
        if moves:
            moved = motion.values[:, list(moves.values())]
            axes = list(moves)
            replace = root_offset == "replace" if joint == 0 else _holds_offset(moved, motion.offsets[joint, axes])
            translation[:, joint, axes] = moved if replace else moved + motion.offsets[joint, axes]
        first += len(letters)
    for order, places in columns.items():
        if order:
            turned = [joint for joint, _ in places]
            angles = np.radians(motion.values[:, [turns for _, turns in places]])
            rotation[:, turned] = euler_to_quaternion(angles, order)
    return LocalPose(translation, rotation)


def _holds_offset(moved: Float64, offset: Float64) -> bool:
    """Whether position channels of an inner joint hold the whole offset (then it must not be added again)."""
    return bool(np.median(np.linalg.norm(moved - offset, axis=-1)) < np.median(np.linalg.norm(moved, axis=-1)))
