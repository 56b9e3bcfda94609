"""Rotations of the engine's joints from landmarks in stage axes: directions of bones, hinges, twists."""

from typing import Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.motion import quaternion
from live.motion.capture.landmark_kernels import (
    ANKLE,
    ELBOW,
    FRAMES,
    HIP,
    INDEX,
    KNEE,
    LEFT_EAR,
    NOSE,
    RIGHT_EAR,
    SHOULDER,
    TOE,
    WRIST,
    find_directions,
    pose_joints,
)
from live.motion.skeleton import JOINT_COUNT, SKELETON

_JOINT: Final = {name: number for number, name in enumerate(SKELETON.names)}
_LIMBS: Final = (("left", "Arm"), ("right", "Arm"), ("left", "Leg"), ("right", "Leg"))
POSED: Final = np.array(
    [
        *(_JOINT[name] for name in ("hips", "upperChest", "head")),
        *(_JOINT[side + part + limb] for part in ("Upper", "Lower") for side, limb in _LIMBS),
        *(_JOINT[side + ("Hand" if limb == "Arm" else "Foot")] for side, limb in _LIMBS),
    ],
    np.int64,
)
"""Joints whose rotation in the world comes from landmarks, in the order of the kernel's frames (15,)."""
HEEL_TO_TOE: Final = (0.0, -0.02, 1.0)
"""Direction from the landmark of the heel to that of the toe in a foot that stands flat."""
FACE_DIRECTION: Final = (0.0, -0.15, 1.0)
"""Direction from the middle of the ears to that of nose, eyes and mouth in a head held straight."""
_X, _Y, _Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
_LEFT, _DOWN = (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0)
_BONES: Final = (_X, _LEFT, _DOWN, _DOWN)
_HINGES: Final = (_DOWN, _Y, _X, _X)
_ALONG_AT_REST: Final = np.array((_X, _X, FACE_DIRECTION, *_BONES, *_BONES, _X, _LEFT, HEEL_TO_TOE, HEEL_TO_TOE))
_SIDE_AT_REST: Final = np.array((_Y, _Y, _X, *_HINGES, *_HINGES, _Z, _Z, _X, _X))
"""Directions of each frame's two axes in the rest pose: bone (or line through both sides), and hinge or side."""


def _inverse_rest() -> Float64:
    """Return the inverse rotations (15, 4) of the frames in the rest pose."""
    x = quaternion.unit(_ALONG_AT_REST)
    y = quaternion.unit(_SIDE_AT_REST - x * np.sum(x * _SIDE_AT_REST, axis=1, keepdims=True))
    return np.ascontiguousarray(quaternion.inverse(quaternion.from_columns(x, y, np.cross(x, y))), np.float64)


INVERSE_REST: Final = _inverse_rest()
_MIXES: Final = np.array(
    [
        (_JOINT["spine"], _JOINT["hips"], _JOINT["upperChest"], 1.0 / 3.0),
        (_JOINT["chest"], _JOINT["hips"], _JOINT["upperChest"], 2.0 / 3.0),
        (_JOINT["neck"], _JOINT["upperChest"], _JOINT["head"], 0.5),
    ]
)
_SAME: Final = np.array(
    [
        _JOINT[name]
        for side in ("left", "right")
        for name in (side + "Shoulder", "upperChest", side + "Toes", side + "Foot")
    ],
    np.int64,
)


def _seen_by() -> Int64:
    """Return for each joint the three landmarks that determine it (J, 3), as rows of the landmarks."""
    rows = np.zeros((JOINT_COUNT, 3), np.int64)
    trunk = (HIP, HIP + 1, SHOULDER)
    rows[:] = trunk
    head, chest = (LEFT_EAR, RIGHT_EAR, NOSE), (SHOULDER, SHOULDER + 1, HIP)
    for name, seen in (("hips", trunk), ("upperChest", chest), ("neck", head), ("head", head)):
        rows[_JOINT[name]] = seen
    for n, side in enumerate(("left", "right")):
        for name, first, second, third in (
            ("UpperArm", SHOULDER, ELBOW, ELBOW), ("LowerArm", ELBOW, WRIST, WRIST), ("Hand", WRIST, INDEX, INDEX),
            ("UpperLeg", HIP, KNEE, KNEE), ("LowerLeg", KNEE, ANKLE, ANKLE), ("Foot", ANKLE, TOE, TOE),
            ("Shoulder", SHOULDER, HIP, HIP), ("Toes", ANKLE, TOE, TOE),
        ):  # fmt: skip
            rows[_JOINT[side + name]] = (first + n, second + n, third + n)
    return rows


SEEN_BY: Final = _seen_by()
"""For each joint the landmarks that determine it (J, 3)."""


class JointRotations:
    """Finds rotations; holds the arrays for it."""

    def __init__(self) -> None:
        self._along, self._side = np.zeros((FRAMES, 3)), np.zeros((FRAMES, 3))
        self.world = np.zeros((JOINT_COUNT, 4))
        """World rotations of all joints (J, 4) after `find`."""

    def find(self, points: Float64) -> Float64:
        """Return the world rotations (J, 4) of all joints from landmarks (L, 3) in stage axes.

        Pelvis and chest turn with the lines through hips and shoulders and lean with the trunk; spine, chest and neck
        share what is between. Knees and elbows bend about their hinge, one way only; where they are straight, foot and
        neighbours tell the twist.
        """
        find_directions(self._along, self._side, points)
        pose_joints(self.world, self._along, self._side, INVERSE_REST, POSED, _MIXES, _SAME)
        return self.world
