"""Charts: joint angles as curves that go on without a jump or a singularity, and back to rotations.

A chart is chosen for each joint by what it has to hold: the rotation vector from the joint's mean rotation where
nothing goes near half a turn from it, else that order of Euler angles whose middle angle stays farthest from a right
angle, with outer angles that count full turns. The hips' first angle is always the heading.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.euler import euler_to_quaternion
from live.motion.rotation_mean import mean_rotation

Float = npt.NDArray[np.floating]
Float64 = npt.NDArray[np.float64]

VECTOR: Final = "vector"
FARTHEST: Final = np.radians(150.0)
"""A rotation vector serves where no rotation is farther from the mean than this."""
HIP_ORDERS: Final = ("YXZ", "YZX")
ORDERS: Final = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")


@dataclass(frozen=True, slots=True, eq=False)
class Chart:
    """How the rotations of one joint become three angles."""

    kind: str
    """"vector", or an order of Euler angles (as in `euler_to_quaternion`)."""
    middle: Float64
    """Rotation from which angles are counted, (4,)."""
    margin: float
    """How far what it was chosen for stays away from where it fails [rad]."""

    def angles(self, rotation: Float) -> Float64:
        """Angles [rad] (T, 3) of rotations (T, 4), continuous in time."""
        away = quaternion.mul(quaternion.inverse(self.middle), np.asarray(rotation, np.float64))
        if self.kind == VECTOR:
            return _vectors(away)
        return _settled(np.unwrap(euler_angles(away, self.kind), axis=0))

    def rotations(self, angles: Float) -> Float64:
        """Rotations (T, 4), unit, of angles (T, 3) [rad]."""
        if self.kind == VECTOR:
            away = quaternion.from_rotation_vector(np.asarray(angles, np.float64))
        else:
            away = euler_to_quaternion(angles, self.kind)
        return np.asarray(quaternion.unit(quaternion.mul(self.middle, away)), np.float64)


def choose_charts(rotation: Float) -> tuple[Chart, ...]:
    """A chart for each joint that holds `rotation` (T, J, 4), all that is to be held, in whatever order; joint 0 is
    the hips."""
    rotation = np.asarray(rotation, np.float64)
    charts = [_best_order(rotation[:, 0], np.array(quaternion.IDENTITY), HIP_ORDERS)]
    middles = mean_rotation(rotation)
    for joint in range(1, rotation.shape[1]):
        middle = middles[joint]
        cosine = np.abs(rotation[:, joint] @ middle)
        angle = float(2.0 * np.arccos(min(1.0, float(cosine.min()))))
        if angle <= FARTHEST:
            charts.append(Chart(VECTOR, np.asarray(middle, np.float64), np.pi - angle))
        else:
            charts.append(_best_order(rotation[:, joint], middle, ORDERS))
    return tuple(charts)


def euler_angles(rotation: Float, order: str) -> Float64:
    """The three angles [rad] (..., 3) of unit quaternions (..., 4) in an `order` of three different axes.

    They undo `euler_to_quaternion`; the middle one is within a right angle.
    """
    i, j, k = ("XYZ".index(axis) for axis in order)
    sign = 1.0 if (j - i) % 3 == 1 else -1.0
    w = rotation[..., 0]
    v = (rotation[..., 1], rotation[..., 2], rotation[..., 3])

    def cell(row: int, column: int) -> Float64:
        if row == column:
            p, r = (n for n in range(3) if n != row)
            return np.asarray(1.0 - 2.0 * (v[p] * v[p] + v[r] * v[r]))
        third = 3 - row - column
        turn = 1.0 if (column - row) % 3 == 1 else -1.0
        return np.asarray(2.0 * (v[row] * v[column] - turn * w * v[third]))

    middle = np.arcsin(np.clip(sign * cell(i, k), -1.0, 1.0))
    first = np.arctan2(-sign * cell(j, k), cell(k, k))
    last = np.arctan2(-sign * cell(i, j), cell(i, i))
    return np.stack((first, middle, last), axis=-1)


def _best_order(rotation: Float, middle: Float, orders: tuple[str, ...]) -> Chart:
    away = quaternion.mul(quaternion.inverse(middle), rotation)
    margins = [0.5 * np.pi - float(np.abs(euler_angles(away, order)[:, 1]).max()) for order in orders]
    best = int(np.argmax(margins))
    return Chart(orders[best], np.asarray(middle, np.float64), margins[best])


def _vectors(away: Float) -> Float64:
    """Rotation vectors (T, 3), up to a full turn long, of quaternions (T, 4) followed in time."""
    q = quaternion.continuous(away)
    if q[:, 0].mean() < 0.0:
        q = -q
    sine = np.linalg.norm(q[:, 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, q[:, :1])
    return np.asarray(np.where(sine < 1e-9, 2.0, angle / np.maximum(sine, 1e-9)) * q[:, 1:])


def _settled(angles: Float64) -> Float64:
    """Outer angles by so many full turns less that their median lies within half a turn of 0."""
    turns = np.round(np.median(angles, axis=0) / (2.0 * np.pi))
    turns[1] = 0.0
    return np.asarray(angles - 2.0 * np.pi * turns)
