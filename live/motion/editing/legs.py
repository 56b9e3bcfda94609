"""Legs that reach for given places: after an edit of whole poses the feet go where they belong."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON
from live.motion.two_bone_ik import two_bone

Float = npt.NDArray[np.floating]

_SOFTNESS: Final = 0.002
"""Recorded legs are often quite straight: they may stay so, to a few tenths of a percent of their length."""
_FORWARD: Final = np.array((0.0, 0.0, 1.0))
_LEGS: Final = tuple(
    tuple(SKELETON.index(side + joint) for joint in ("UpperLeg", "LowerLeg", "Foot")) for side in ("left", "right")
)


def reach_with_feet(root: Float, rotation: Float, ankles: Float, feet: Float) -> Float:
    """Local rotations (T, J, 4) whose ankles are at `ankles` and whose feet have the world rotations `feet` (T, 2, 4).

    `root` (T, 3) and `rotation` (T, J, 4) are the pose to start from, which knees and thighs stay nearest to;
    `ankles` (T, 2, 3) [m]. Everything but the legs is as given; bones keep their lengths, so what lies out of a
    leg's reach is pointed at.
    """
    position, world = forward_kinematics(root, rotation)
    result = rotation.copy()
    for side, (upper, lower, foot) in enumerate(_LEGS):
        hip, knee, ankle = position[:, upper], position[:, lower], position[:, foot]
        pole = knee - 0.5 * (hip + ankle) + 0.05 * quaternion.rotate(world[:, upper], _FORWARD)
        new_knee, new_ankle = two_bone(
            hip, ankles[:, side], pole, upper=_length(lower), lower=_length(foot), softness=_SOFTNESS
        )
        thigh = quaternion.mul(quaternion.from_two_vectors(knee - hip, new_knee - hip), world[:, upper])
        shin = quaternion.mul(quaternion.from_two_vectors(ankle - knee, new_ankle - new_knee), world[:, lower])
        result[:, upper] = quaternion.mul(quaternion.inverse(world[:, 0]), thigh)
        result[:, lower] = quaternion.mul(quaternion.inverse(thigh), shin)
        result[:, foot] = quaternion.mul(quaternion.inverse(shin), feet[:, side])
    return result


def _length(joint: int) -> float:
    return float(np.linalg.norm(SKELETON.offsets[joint].astype(np.float64)))
