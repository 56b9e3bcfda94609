"""Frequency bands of a signal: a Laplacian pyramid that keeps its sampling (P003).

Band 1 is the highest. Each next one comes of a filter twice as long (Burt and Adelson's B-spline 1 4 6 4 1, with
zeros between its taps), so bands keep the signal's rate, move with it in time, and add up to it exactly.

Charts: joint angles as curves that go on without a jump or a singularity, and back to rotations.

A chart is chosen for each joint by what it has to hold: the rotation vector from the joint's mean rotation where
nothing goes near half a turn from it, else that order of Euler angles whose middle angle stays farthest from a right
angle, with outer angles that count full turns. The hips' first angle is always the heading.

Tracks: a clip as degrees of freedom at 24 samples a second, three for each joint and three for the body's sway.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.quaternion import euler_to_quaternion, mean_rotation
from live.motion.skeleton import JOINT_COUNT

Float = npt.NDArray[np.floating]
Float64 = npt.NDArray[np.float64]

RATE: Final = 24.0
"""Samples per second in which bands are counted, as in the paper [Hz]: band 1 is 6 to 12 Hz, band 2 is 3 to 6 Hz."""
MOST_BANDS: Final = 10
"""Band 10 at 24 samples a second has a period of a minute."""


def split_bands(signal: Float, count: int) -> Float64:
    """`count` bands of `signal` (T, ...), the highest first, and what is left of it, (count + 1, T, ...).

    Their sum is the signal. Beyond its ends a signal goes on reflected in its end *points*, x(-t) = 2 x(0) - x(t):
    so a line has no bands, all bands are 0 at both ends, and nothing of a trend comes into them.
    """
    if count < 0:
        raise ValueError(f"{count} bands: 0 or more expected")
    rest = np.array(signal, np.float64)
    out = np.empty((count + 1, *rest.shape))
    for band in range(count):
        lower = lower_half(rest, 1 << band)
        out[band] = rest - lower
        rest = lower
    out[count] = rest
    return out


def lower_half(signal: Float64, spacing: int) -> Float64:
    """`signal` (T, ...) without its upper half of frequencies at a filter whose taps are `spacing` samples apart."""
    length = len(signal)
    if length < 2:
        return signal.copy()
    reach = 2 * spacing
    if reach < length:  # one reflection at each end is all that the filter sees
        before = 2.0 * signal[0] - signal[reach:0:-1]
        after = 2.0 * signal[-1] - signal[-2 : -2 - reach : -1]
        wide = np.concatenate((before, signal, after))
    else:
        wide = _reflected(signal, reach)
    parts = [wide[n * spacing : n * spacing + length] for n in range(5)]
    return np.asarray((parts[0] + parts[4] + 4.0 * (parts[1] + parts[3]) + 6.0 * parts[2]) / 16.0)


def _reflected(signal: Float64, reach: int) -> Float64:
    """The signal with `reach` samples more at both ends, however often it must be reflected for that."""
    last = len(signal) - 1
    at = np.arange(-reach, last + reach + 1)
    shape = (-1, *(1,) * (signal.ndim - 1))
    slope = (signal[-1] - signal[0]) / last
    flat = signal - signal[0] - np.arange(last + 1.0).reshape(shape) * slope  # 0 at both ends: odd about them
    turn = at % (2 * last)
    back = turn > last
    wide = flat[np.where(back, 2 * last - turn, turn)] * np.where(back, -1.0, 1.0).reshape(shape)
    return np.asarray(wide + signal[0] + at.reshape(shape) * slope)


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


Int64 = npt.NDArray[np.int64]

SWAY: Final = JOINT_COUNT
"""The "joint" after the last one: where the hips are, to their left, up and forward [m]."""
SLOW: Final = 5
"""Bands of heading and sway that are kept: what is slower is the way itself, which is the sketch's."""
COLUMNS: Final = 3 * (JOINT_COUNT + 1)
"""Degrees of freedom of a clip."""


def columns_of(joints: Sequence[int]) -> Int64:
    """The columns of the degrees of freedom of `joints`."""
    return np.array([3 * joint + axis for joint in joints for axis in range(3)], np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class Sampled:
    """A clip at `RATE`: hips (T, 3) [m] and rotations (T, J, 4), float64. The last sample holds the clip's end."""

    clip: Clip
    root: Float
    rotation: Float


def sample_clip(clip: Clip) -> Sampled:
    """The clip at `RATE` samples a second. Neighbouring samples are degrees apart: the chord stands for the arc."""
    last = clip.sample_count - 1
    count = int(np.ceil(last * RATE / clip.sample_rate - 1e-6)) + 1
    at = np.minimum(np.arange(count) * (clip.sample_rate / RATE), last)
    before = np.minimum(at.astype(np.int64), max(last - 1, 0))
    part = at - before
    after = np.minimum(before + 1, last)
    root = clip.root_position
    hips = root[before] * (1.0 - part[:, None]) + root[after] * part[:, None]
    a, b = clip.rotation[before], clip.rotation[after]
    weight = part.astype(np.float32)[:, None, None]
    sign = np.where(np.sum(a * b, axis=-1, keepdims=True) < 0.0, np.float32(-1.0), np.float32(1.0))
    rotation = a * (1.0 - weight) + b * (weight * sign)
    return Sampled(clip, hips.astype(np.float64), np.asarray(quaternion.unit(rotation.astype(np.float64))))


def charts_for(samples: Sequence[Sampled]) -> tuple[Chart, ...]:
    """Charts that hold all of these clips."""
    return choose_charts(np.concatenate([one.rotation for one in samples]))


def tracks_of(sampled: Sampled, charts: Sequence[Chart]) -> Float64:
    """All degrees of freedom (T, COLUMNS) [rad, m] of a clip.

    The heading and the sway are what is beside their slow course. The sway is where the hips are beside their slow
    way, in the axes of the hips' heading: dancers sway alike wherever they go.
    """
    out = np.empty((len(sampled.root), COLUMNS))
    for joint, chart in enumerate(charts):
        out[:, 3 * joint : 3 * joint + 3] = chart.angles(sampled.rotation[:, joint])
    out[:, 0] -= split_bands(out[:, 0], SLOW)[-1]
    out[:, 3 * SWAY :] = turned(sampled.root - _way(sampled.root), -headings(sampled.rotation[:, 0]))
    return out


def headings(hips: Float) -> Float64:
    """Headings [rad] (T,) of the hips' rotations (T, 4), about the vertical."""
    return np.asarray(np.unwrap(euler_angles(np.asarray(hips, np.float64), "YXZ")[..., 0]))


def turned(vectors: Float, heading: Float) -> Float64:
    """Vectors (T, 3) turned about the vertical by `heading` (T,)."""
    sine, cosine = np.sin(heading), np.cos(heading)
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack((cosine * x + sine * z, y, -sine * x + cosine * z), axis=-1)


def _way(root: Float) -> Float64:
    """The slow way of the hips over the floor, (T, 3): lower than band `SLOW`; no height."""
    way = split_bands(root, SLOW)[-1]
    way[:, 1] = 0.0
    return np.asarray(way)
