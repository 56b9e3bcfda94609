"""One Euro filter: less lag the faster something moves, for places and rotations, with prediction.

Casiez, Roussel, Vogel 2012, "1 € Filter: A Simple Speed-based Low-pass Filter for Noisy Input in Interactive Systems":
a first-order low-pass whose cut-off rises with the (filtered) speed.
"""

import math
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.motion.capture.landmark_kernels import filter_rotations, predict_rotations
from live.motion.skeleton import JOINT_COUNT, SKELETON

MAX_LEAD: Final = 0.15
"""Longest prediction [s]."""
_PARENTS: Final = np.array(SKELETON.parents, np.int32)


def follow(cutoff: float, dt: float) -> float:
    """Return the share of the way to a new value that a low-pass of `cutoff` [Hz] goes in `dt` [s]."""
    pace = 2.0 * math.pi * cutoff * dt
    return pace / (1.0 + pace)


class PlaceFilter:
    """Filters a place (n,) [m]."""

    def __init__(self, cutoff: float, gain: float, speed_cutoff: float) -> None:
        """`cutoff` [Hz] at rest, `gain` [Hz per m/s], `speed_cutoff` [Hz] of the speed's filter."""
        self._cutoff, self._gain, self._speed_cutoff = cutoff, gain, speed_cutoff
        self._last = np.zeros(0)
        self.value = np.zeros(0)
        """The filtered place (n,) [m]."""
        self.speed = np.zeros(0)
        """(n,) [m/s]."""

    def update(self, place: Float64, dt: float) -> Float64:
        """Return the place (n,) [m] filtered, `dt` [s] after the last; 0 takes it as it is."""
        if dt <= 0.0:
            self.value, self.speed = np.array(place), np.zeros(len(place))
            self._last = self.value
            return self.value
        self.speed = self.speed + follow(self._speed_cutoff, dt) * ((place - self._last) / dt - self.speed)
        self._last = np.array(place)
        cutoff = self._cutoff + self._gain * math.sqrt(self.speed @ self.speed)
        self.value = self.value + follow(cutoff, dt) * (place - self.value)
        return self.value


class RotationFilter:
    """Filters the local rotations of all joints."""

    def __init__(self, cutoff: float, gain: float, speed_cutoff: float) -> None:
        """`cutoff` [Hz] at rest, `gain` [Hz per rad/s], `speed_cutoff` [Hz] of the speed's filter."""
        self._settings = np.array((cutoff, gain, speed_cutoff))
        self._last = np.zeros((JOINT_COUNT, 4))
        self.value = np.zeros((JOINT_COUNT, 4))
        """The filtered rotations (J, 4)."""
        self.speed = np.zeros((JOINT_COUNT, 3))
        """Their angular velocities in their own axes (J, 3) [rad/s]."""

    def update(self, world: Float64, dt: float, trust: Float64) -> Float64:
        """Return the local rotations (J, 4) of `world` rotations (J, 4), filtered, `dt` [s] after the last.

        `trust` (J,), 0 to 1, slows joints; 0 holds. A `dt` of 0 takes the rotations as they are.
        """
        filter_rotations(self.value, self.speed, self._last, world, _PARENTS, trust, dt, self._settings)
        return self.value

    def predicted(self, lead: float) -> Float64:
        """Return the rotations (J, 4) `lead` [s] after the last ones, at most `MAX_LEAD`; a new array."""
        out = np.empty((JOINT_COUNT, 4))
        predict_rotations(out, self.value, self.speed, min(max(lead, 0.0), MAX_LEAD))
        return out
