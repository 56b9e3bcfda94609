"""A body's motion as regular moments, from poses that arrive at any rate: what gestures and movement are read from.

Poses become joint positions, are interpolated to `RATE` moments a second and smoothed, and each moment is measured
relative to the body (`gesture_kernels`): place, heading and the body's size do not matter, because all poses are on
the engine's skeleton.
"""

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from live.base.arrays import Float32, Float64, Int64
from live.motion.recognition.gesture_kernels import (
    FEATURES,
    MEASURES,
    joint_positions,
    measure_body,
)
from live.motion.skeleton import JOINT_COUNT, SKELETON

RATE: Final = 32.0
"""Moments per second."""
SMOOTHING_S: Final = 0.05
"""Time constant of the smoothing of joint positions [s]: less than a camera's delay, more than its jitter."""
GAP_S: Final = 0.25
"""Silence [s] after which the motion begins anew."""
KEY_JOINT: Final[Int64] = np.array(
    [SKELETON.index(name) for name in (
        "head", "leftLowerArm", "leftHand", "rightLowerArm", "rightHand", "leftLowerLeg", "leftFoot",
        "rightLowerLeg", "rightFoot",
    )], np.int64,
)  # fmt: skip
"""The joints of a gesture's features, (KEY_JOINTS,)."""
_SHARE: Final = 1.0 - math.exp(-1.0 / (RATE * SMOOTHING_S))
_OFFSETS: Final = np.array(SKELETON.offsets, np.float32)
_PARENTS: Final = np.array(SKELETON.parents, np.int32)


class BodyStream:
    """The moments of one body. Thread: one at a time."""

    def __init__(self) -> None:
        self.count = 0
        """Number of moments so far, since the beginning or the last gap."""
        self.measure: Float64 = np.zeros(MEASURES)
        """What the body does at the last moment, see `gesture_kernels`, (MEASURES,)."""
        self.feature: Float64 = np.zeros(FEATURES)
        """Its features for examples, (FEATURES,)."""
        self._joint: Float64 = np.zeros((JOINT_COUNT, 3))
        self._smooth: Float64 = np.zeros((JOINT_COUNT, 3))
        self._heading = 0.0
        self._time = -math.inf

    @property
    def time(self) -> float:
        """Time of the last pose [s]."""
        return self._time

    def feed(self, hips: Float32, rotation: Float32, time: float) -> Iterator[float]:
        """Take a pose at `time` [s] and yield the time [s] of each new moment while `measure` and `feature` hold it.

        `hips` (3,) [m], `rotation` (J, 4) local unit quaternions. The caller consumes the iterator. A pose older than
        the last one is left out.
        """
        since, passed = self._time, time - self._time
        if passed <= 0.0:
            return
        self._time = time
        joint = np.empty((JOINT_COUNT, 3))
        joint_positions(joint, hips, rotation, _OFFSETS, _PARENTS)
        if passed > GAP_S:
            self.count = 0
            self._joint[:] = self._smooth[:] = joint
            self._measure(joint, 1.0, 1.0)
            self.feature[:] = 0.0  # else the change of heading over the gap would be a turn
            self._measure(joint, 1.0, 1.0)
            return
        first = math.floor(since * RATE) + 1
        for moment in range(first, math.floor(time * RATE) + 1):
            share = (moment / RATE - since) / passed
            self._measure(joint, share, _SHARE)
            self.count += 1
            yield moment / RATE
        self._joint[:] = joint

    def _measure(self, joint: Float64, part: float, share: float) -> None:
        """Measure the moment at `part` of the way from the last pose to `joint` (J, 3)."""
        self._heading = measure_body(
            self.measure, self.feature, self._smooth, self._joint, joint, part, share, KEY_JOINT, self._heading, RATE
        )
