"""Feet of a seen person: contact with the floor, and planted feet that stand still and flat."""

from typing import Final

import numpy as np

from live.base.arrays import Bool, Float64
from live.motion.capture.joint_rotations import INVERSE_REST
from live.motion.capture.landmark_kernels import FOOT_COLUMNS, HEEL, TOE, UPPER, find_feet, plant_feet
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.skeleton import SKELETON, SOLE_BELOW_ANKLE

_OFFSETS: Final = np.array(SKELETON.offsets, np.float64)
_LEGS: Final = np.array(
    [[SKELETON.index(side + part) for part in ("UpperLeg", "LowerLeg", "Foot", "Toes")] for side in ("left", "right")],
    np.int64,
)
_LEG_REST: Final = np.array(INVERSE_REST[UPPER + 2])
SOLES: Final = np.array((HEEL, TOE, HEEL + 1, TOE + 1))
"""Landmarks of heel and toe, left and right."""
SOLE_HEIGHTS: Final = np.array((0.055, 0.02, 0.055, 0.02))
"""Their heights [m] over the floor when the foot stands: where the model sees them, within the shoe."""

SPEED_ON, SPEED_OFF = 0.3, 0.5
"""Speeds [m/s] of the slower of heel and toe under which a contact starts and over which it ends. Speed along the
camera's ray does not count, as it is mostly noise; so the thresholds are near those for recordings
(`live.motion.foot_contact`)."""
HEIGHT_ON, HEIGHT_OFF = 0.06, 0.11
"""Heights [m] of the lower of both over a standing one under which a contact starts and over which it ends."""
SPEED_SPAN: Final = 0.07
"""The time [s] over which the speed is measured."""
BRAKE_AHEAD, BRAKE_SPEED, BRAKE_FROM = 0.067, 0.2, 1.0
"""A contact also starts where a foot slower than `BRAKE_FROM` [m/s] brakes so hard that it will be slower than
`BRAKE_SPEED` [m/s] in `BRAKE_AHEAD` [s]: a measured speed is as old as half its span."""
_SETTINGS: Final = np.array((0.12, 0.05, 0.04, 0.012, SOLE_BELOW_ANKLE, TOES_OVER_SOLE, 0.12, 0.2, 0.3, 0.5))
"""Settings of `plant_feet`: a planted foot farther from where it is seen than 12 cm follows. Along the camera's ray, in
which the hips' place is least sure, the hips go with the feet instead."""


class StandingFeet:
    """State of both feet, updated once per picture."""

    def __init__(self) -> None:
        self.contact: Bool = np.zeros(2, np.bool_)
        """Whether the left and the right foot stand on the floor."""
        self._state = np.zeros((2, FOOT_COLUMNS))
        self._drift, self._unsure = np.zeros(1), np.zeros(2)
        self._seen: list[tuple[float, Float64]] = []
        self._speed: tuple[float, Float64] | None = None

    def observe(self, soles: Float64, depth: Float64, time: float) -> None:
        """Find the contacts at `time` [s] from the places of `SOLES` (4, 3) [m], heights over the floor.

        `depth` (3,) is the direction in which they are not sure.
        """
        while len(self._seen) > 1 and time - self._seen[1][0] >= SPEED_SPAN - 0.01:
            self._seen.pop(0)
        flat = float(np.hypot(depth[0], depth[2]))
        self._unsure = depth[::2] / flat if flat > 0.3 else np.zeros(2)
        if self._seen:
            begin, there = self._seen[0]
            moved = soles - there
            moved = moved - (moved @ depth)[:, None] * depth
            speed = (np.sqrt(np.sum(moved * moved, axis=1)) / max(time - begin, 1e-3)).reshape(2, 2).min(axis=1)
            height = (soles[:, 1] - SOLE_HEIGHTS).reshape(2, 2).min(axis=1)
            stops = (speed < BRAKE_FROM) & (self._speed_ahead(speed, time) < BRAKE_SPEED)
            lands = (height < HEIGHT_ON) & ((speed < SPEED_ON) | stops)
            leaves = (height > HEIGHT_OFF) | (speed > SPEED_OFF)
            self.contact = lands | (self.contact & ~leaves)
        self._seen.append((time, soles))

    def _speed_ahead(self, speed: Float64, time: float) -> Float64:
        """Return the speeds (2,) [m/s] in `BRAKE_AHEAD` if they go on changing as since the last picture."""
        last, self._speed = self._speed, (time, speed)
        if last is None:
            return speed
        return np.asarray(speed + (speed - last[1]) * (BRAKE_AHEAD / max(time - last[0], 1e-3)))

    def plant(self, hips: Float64, rotation: Float64, dt: float) -> None:
        """Plant the feet: changes `hips` (3,) [m] and the legs of local `rotation` (J, 4), `dt` [s] after the last."""
        plant_feet(
            hips, rotation, self._state, self._drift, self.contact, self._unsure,
            _OFFSETS, _LEGS, _LEG_REST, _SETTINGS, dt,
        )  # fmt: skip


def lowest_sole(rotation: Float64) -> float:
    """Return how high the lowest sole is over the hips [m], below zero, with local `rotation` (J, 4)."""
    feet = np.empty((2, 2, 3))
    find_feet(feet, np.zeros(3), rotation, _OFFSETS, _LEGS)
    return float(min(feet[:, 0, 1].min() - SOLE_BELOW_ANKLE, feet[:, 1, 1].min() - TOES_OVER_SOLE))
