"""Retargeting of a live captured skeleton to the engine's, with floor estimation."""

from typing import Final

import numpy as np

from live.base.arrays import Bool, Float64
from live.motion.capture.capture_kernels import retarget_pose
from live.motion.capture.packed_pose import pack_pose
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.skeleton import JOINT_COUNT, SKELETON, SOLE_BELOW_ANKLE

FLOOR_WINDOW: Final = 2.0
"""Window [s] in which a foot certainly touches the floor (a jump lasts less than 1 s)."""
FLOOR_HALFLIFE: Final = 0.3
"""Half-life with which the estimate approaches the measured floor [s]."""
_WINDOW_PARTS: Final = 8
_LIMBS: Final = np.array([name.endswith(("UpperArm", "LowerArm", "UpperLeg", "LowerLeg")) for name in SKELETON.names])
_LEGS: Final = np.array(
    [SKELETON.index(side + bone) for side in ("left", "right") for bone in ("UpperLeg", "LowerLeg", "Foot", "Toes")],
    np.int32,
)
_OFFSETS: Final = np.array(SKELETON.offsets, np.float32)
_PARENTS: Final = np.array(SKELETON.parents, np.int32)
_SOLES: Final = np.array([SOLE_BELOW_ANKLE, TOES_OVER_SOLE])


class FloorEstimator:
    """Floor height under a captured person: the lowest sole of the last seconds, smoothed."""

    def __init__(self) -> None:
        self._lows = [np.inf] * _WINDOW_PARTS
        self._part = -1
        self._time = 0.0
        self.height = 0.0
        """Current estimate [m]."""

    def update(self, lowest: float, time: float) -> float:
        """Update with the lowest sole at `lowest` [m] at `time` [s]; return the estimated floor height."""
        part = int(time / FLOOR_WINDOW * _WINDOW_PARTS)
        first = self._part < 0 or part - self._part >= _WINDOW_PARTS
        for each in range(max(self._part + 1, part - _WINDOW_PARTS + 1), part + 1):
            self._lows[each % _WINDOW_PARTS] = np.inf
        self._part = max(part, self._part)
        self._lows[part % _WINDOW_PARTS] = min(self._lows[part % _WINDOW_PARTS], lowest)
        found = min(self._lows)
        gone = min(max(time - self._time, 0.0), 1.0)
        self.height = found if first else found + (self.height - found) * 0.5 ** (gone / FLOOR_HALFLIFE)
        self._time = time
        return self.height


class CapturedBody:
    """One captured person. To be used from one thread.

    The captured skeleton has the engine's joints, or some of them, with the engine's rest pose (a T-pose facing +z, all
    rotations the identity) and its own bone lengths.
    """

    def __init__(self) -> None:
        self._floor_estimator = FloorEstimator()
        self._hips, self._rotation = np.zeros(3), np.zeros((JOINT_COUNT, 4))

    def pack(self, bones: Float64, known: Bool, root: Float64, time: float, *, find_floor: bool = True) -> str:
        """Return the pose at `time` [s], packed; raises ValueError if it is invalid.

        `bones` (J, 7): position relative to the parent [m] and local rotation (w, x, y, z) of the `known` (J,) joints;
        `root` (7,): pose of the skeleton's origin; in the engine's axes. `find_floor`: move the feet to the floor,
        whatever the capture system's floor height.
        """
        lowest = retarget_pose(
            self._hips, self._rotation, bones, known, root, _OFFSETS, _PARENTS, _LIMBS, _LEGS, _SOLES
        )
        if find_floor and np.isfinite(lowest):
            self._hips[1] -= self._floor_estimator.update(lowest, time)
        return pack_pose(self._hips, self._rotation)
