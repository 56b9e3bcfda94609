"""Clips as tracks of continuous joint angles at 24 Hz, and their frequency bands.

Bands are a Laplacian pyramid without downsampling (P003). Band 1 is the highest. Each next band uses a filter twice as
long (Burt and Adelson's B-spline 1 4 6 4 1, with zeros between its taps). Bands keep the signal's rate and phase and
add up to it exactly.

A chart maps a joint's rotations to angles without jumps or singularities and back. It is the rotation vector from the
mean rotation if all rotations stay well within half a turn of it. Otherwise it is the Euler order whose middle angle
stays farthest from a right angle, with unwrapped outer angles. The hips' first angle is always the heading.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float, Float64, Int64
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.quaternion import euler_to_quaternion, mean_rotation
from live.motion.skeleton import JOINT_COUNT

RATE: Final = 24.0
"""Sample rate of the bands, as in the paper [Hz]: band 1 is 6 to 12 Hz, band 2 is 3 to 6 Hz."""
MAX_BANDS: Final = 10
"""Band 10 at 24 samples a second has a period of a minute."""


def split_bands(signal: Float, count: int) -> Float64:
    """Split `signal` (T, ...) into `count` bands, the highest first, and the residual, (count + 1, T, ...).

    Their sum is the signal. The signal is extended by reflection in its end *points*, x(-t) = 2 x(0) - x(t). So a
    line has no bands, all bands are 0 at both ends, and a trend does not leak into them.
    """
    if count < 0:
        raise ValueError(f"{count} bands: 0 or more expected")
    rest = np.array(signal, np.float64)
    out = np.empty((count + 1, *rest.shape))
    for band in range(count):
        lower = low_pass(rest, 1 << band)
        out[band] = rest - lower
        rest = lower
    out[count] = rest
    return out


def low_pass(signal: Float64, spacing: int) -> Float64:
    """Return `signal` (T, ...) low-passed to its lower half of frequencies, with taps `spacing` samples apart."""
    length = len(signal)
    if length < 2:
        return signal.copy()
    reach = 2 * spacing
    if reach < length:  # the filter spans at most one reflection at each end
        before = 2.0 * signal[0] - signal[reach:0:-1]
        after = 2.0 * signal[-1] - signal[-2 : -2 - reach : -1]
        wide = np.concatenate((before, signal, after))
    else:
        wide = _extend_by_reflection(signal, reach)
    parts = [wide[n * spacing : n * spacing + length] for n in range(5)]
    return np.asarray((parts[0] + parts[4] + 4.0 * (parts[1] + parts[3]) + 6.0 * parts[2]) / 16.0)


def _extend_by_reflection(signal: Float64, reach: int) -> Float64:
    """Return the signal extended by `reach` samples at both ends, reflected as often as needed."""
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
MAX_VECTOR_ANGLE: Final = np.radians(150.0)
"""A rotation vector is used where no rotation is farther from the mean than this [rad]."""
HIP_ORDERS: Final = ("YXZ", "YZX")
ORDERS: Final = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")


@dataclass(frozen=True, slots=True, eq=False)
class Chart:
    """Mapping of one joint's rotations to three angles and back."""

    kind: str
    """"vector", or an order of Euler angles (as in `euler_to_quaternion`)."""
    reference: Float64
    """Reference rotation of the angles, (4,)."""
    margin: float
    """Distance of the rotations it was chosen for from its singularity [rad]."""

    def angles(self, rotation: Float) -> Float64:
        """Return the angles [rad] (T, 3) of rotations (T, 4), continuous in time."""
        away = quaternion.mul(quaternion.inverse(self.reference), np.asarray(rotation, np.float64))
        if self.kind == VECTOR:
            return _rotation_vectors(away)
        return _center_turns(np.unwrap(euler_angles(away, self.kind), axis=0))

    def rotations(self, angles: Float) -> Float64:
        """Return the unit rotations (T, 4) of angles (T, 3) [rad]."""
        if self.kind == VECTOR:
            away = quaternion.from_rotation_vector(np.asarray(angles, np.float64))
        else:
            away = euler_to_quaternion(angles, self.kind)
        return np.asarray(quaternion.unit(quaternion.mul(self.reference, away)), np.float64)


def choose_charts(rotation: Float) -> tuple[Chart, ...]:
    """Return a chart for each joint that covers its rotations in `rotation` (T, J, 4), in any order of samples.

    Joint 0 is the hips.
    """
    rotation = np.asarray(rotation, np.float64)
    charts = [_best_order(rotation[:, 0], np.array(quaternion.IDENTITY), HIP_ORDERS)]
    middles = mean_rotation(rotation)
    for joint in range(1, rotation.shape[1]):
        middle = middles[joint]
        cosine = np.abs(rotation[:, joint] @ middle)
        angle = float(2.0 * np.arccos(min(1.0, float(cosine.min()))))
        if angle <= MAX_VECTOR_ANGLE:
            charts.append(Chart(VECTOR, np.asarray(middle, np.float64), np.pi - angle))
        else:
            charts.append(_best_order(rotation[:, joint], middle, ORDERS))
    return tuple(charts)


def euler_angles(rotation: Float, order: str) -> Float64:
    """Return the three angles [rad] (..., 3) of unit quaternions (..., 4) in an `order` of three different axes.

    Inverse of `euler_to_quaternion`. The middle angle is within ±90 degrees.
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


def _best_order(rotation: Float, reference: Float, orders: tuple[str, ...]) -> Chart:
    away = quaternion.mul(quaternion.inverse(reference), rotation)
    margins = [0.5 * np.pi - float(np.abs(euler_angles(away, order)[:, 1]).max()) for order in orders]
    best = int(np.argmax(margins))
    return Chart(orders[best], np.asarray(reference, np.float64), margins[best])


def _rotation_vectors(away: Float) -> Float64:
    """Return continuous rotation vectors (T, 3), up to a full turn long, of quaternions (T, 4)."""
    q = quaternion.align_signs(away)
    if q[:, 0].mean() < 0.0:
        q = -q
    sine = np.linalg.norm(q[:, 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, q[:, :1])
    return np.asarray(np.where(sine < 1e-9, 2.0, angle / np.maximum(sine, 1e-9)) * q[:, 1:])


def _center_turns(angles: Float64) -> Float64:
    """Return the angles, the outer ones shifted by full turns so that their median is within half a turn of 0."""
    turns = np.round(np.median(angles, axis=0) / (2.0 * np.pi))
    turns[1] = 0.0
    return np.asarray(angles - 2.0 * np.pi * turns)


SWAY: Final = JOINT_COUNT
"""Index of the pseudo-joint after the last one: offset of the hips to their left, up and forward [m]."""
SLOW_BANDS: Final = 5
"""Bands of heading and sway that are kept. Slower motion is the path itself, which comes from the sketch."""
COLUMNS: Final = 3 * (JOINT_COUNT + 1)
"""Number of degrees of freedom of a clip: three for each joint and three for the sway."""


def columns_of(joints: Sequence[int]) -> Int64:
    """Return the columns of the degrees of freedom of `joints`."""
    return np.array([3 * joint + axis for joint in joints for axis in range(3)], np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class SampledClip:
    """A clip at `RATE`: hips (T, 3) [m] and rotations (T, J, 4), float64. The last sample holds the clip's end."""

    clip: Clip
    root: Float
    rotation: Float


def sample_clip(clip: Clip) -> SampledClip:
    """Return the clip at `RATE` samples a second.

    Rotations are interpolated linearly and normalized, because neighbouring samples are only degrees apart.
    """
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
    return SampledClip(clip, hips.astype(np.float64), np.asarray(quaternion.unit(rotation.astype(np.float64))))


def charts_for(samples: Sequence[SampledClip]) -> tuple[Chart, ...]:
    """Return charts that cover all of these clips."""
    return choose_charts(np.concatenate([one.rotation for one in samples]))


def tracks_of(sampled: SampledClip, charts: Sequence[Chart]) -> Float64:
    """Return all degrees of freedom (T, COLUMNS) [rad, m] of a clip.

    Heading and sway are deviations from their low-passed course. The sway is the hips' offset from their smoothed
    path, in the axes of the hips' heading, so it does not depend on the direction of travel.
    """
    out = np.empty((len(sampled.root), COLUMNS))
    for joint, chart in enumerate(charts):
        out[:, 3 * joint : 3 * joint + 3] = chart.angles(sampled.rotation[:, joint])
    out[:, 0] -= split_bands(out[:, 0], SLOW_BANDS)[-1]
    out[:, 3 * SWAY :] = rotate_about_vertical(
        sampled.root - _smoothed_path(sampled.root), -headings(sampled.rotation[:, 0])
    )
    return out


def headings(hips: Float) -> Float64:
    """Return the headings [rad] (T,) of the hips' rotations (T, 4), about the vertical."""
    return np.asarray(np.unwrap(euler_angles(np.asarray(hips, np.float64), "YXZ")[..., 0]))


def rotate_about_vertical(vectors: Float, heading: Float) -> Float64:
    """Return vectors (T, 3) rotated about the vertical by `heading` (T,) [rad]."""
    sine, cosine = np.sin(heading), np.cos(heading)
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack((cosine * x + sine * z, y, -sine * x + cosine * z), axis=-1)


def _smoothed_path(root: Float) -> Float64:
    """Return the smoothed path of the hips over the floor, (T, 3): below band `SLOW`, height 0."""
    way = split_bands(root, SLOW_BANDS)[-1]
    way[:, 1] = 0.0
    return np.asarray(way)
