"""Implicit surface of the dancer's body in the rest pose: smoothly blended lofts and ellipsoids.

The field is zero on the skin, positive outside, about the distance [m] near it. The body is symmetric, so only the
left half is described (left = +x) and points are mirrored into it. All lengths are in metres, for a dancer 1.7 m tall
(eight heads). Lofts follow the bones of `live.motion.skeleton`.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64

_SAMPLES: Final = 65
_TINY: Final = 1e-9


@dataclass(frozen=True, slots=True)
class Ellipsoid:
    """An ellipsoid: centre, radii, and blend width with the parts before it [m]; `pitch_deg` rotates it about x."""

    centre: tuple[float, float, float]
    radii: tuple[float, float, float]
    blend: float
    pitch_deg: float = 0.0


@dataclass(frozen=True, slots=True)
class Loft:
    """A limb: cross-sections along a line from `start` to `end`.

    A row is (t, across, front, back, shift): position along the line from 0 to 1, the half-width along `across`,
    the half-widths in front of and behind the line (a calf bulges behind only), and a shift of the line to the front.
    """

    start: tuple[float, float, float]
    end: tuple[float, float, float]
    across: tuple[float, float, float]
    rows: tuple[tuple[float, float, float, float, float], ...]
    blend: float


def _upright(x: float, z: float, rows: tuple[tuple[float, float, float, float, float], ...], blend: float) -> Loft:
    """Return a vertical loft whose rows have heights y [m] from the top down instead of t."""
    top, bottom = rows[0][0], rows[-1][0]
    scaled = tuple(((top - y) / (top - bottom), *rest) for y, *rest in rows)
    return Loft((x, top, z), (x, bottom, z), (1.0, 0.0, 0.0), scaled, blend)  # type: ignore[arg-type]


TORSO: Final = _upright(
    0.0,
    0.0,
    (
        (1.415, 0.070, 0.036, 0.050, -0.018),
        (1.380, 0.122, 0.058, 0.070, -0.014),
        (1.330, 0.140, 0.083, 0.086, -0.008),
        (1.270, 0.138, 0.096, 0.090, -0.004),
        (1.200, 0.128, 0.093, 0.085, 0.000),
        (1.120, 0.113, 0.083, 0.074, 0.004),
        (1.060, 0.108, 0.079, 0.070, 0.006),
        (1.000, 0.117, 0.081, 0.076, 0.005),
        (0.940, 0.135, 0.085, 0.090, 0.002),
        (0.890, 0.146, 0.083, 0.098, 0.000),
        (0.850, 0.140, 0.074, 0.092, 0.000),
        (0.815, 0.100, 0.052, 0.068, 0.000),
    ),
    0.0,
)
NECK: Final = _upright(
    0.0,
    0.0,
    (
        (1.540, 0.042, 0.042, 0.046, 0.000),
        (1.480, 0.041, 0.041, 0.046, -0.005),
        (1.420, 0.047, 0.045, 0.052, -0.014),
        (1.380, 0.060, 0.046, 0.056, -0.022),
    ),
    0.045,
)
LEG: Final = _upright(
    0.09,
    0.0,
    (
        (0.920, 0.062, 0.066, 0.070, 0.0),
        (0.860, 0.075, 0.078, 0.084, 0.0),
        (0.790, 0.077, 0.084, 0.086, 0.0),
        (0.710, 0.070, 0.082, 0.077, 0.0),
        (0.620, 0.060, 0.071, 0.066, 0.0),
        (0.540, 0.050, 0.058, 0.055, 0.0),
        (0.495, 0.047, 0.053, 0.050, 0.0),
        (0.465, 0.046, 0.051, 0.049, 0.0),
        (0.425, 0.045, 0.044, 0.054, 0.0),
        (0.365, 0.048, 0.040, 0.066, 0.0),
        (0.305, 0.045, 0.038, 0.062, 0.0),
        (0.225, 0.034, 0.034, 0.044, 0.0),
        (0.150, 0.027, 0.030, 0.033, 0.0),
        (0.100, 0.028, 0.031, 0.035, 0.0),
        (0.055, 0.030, 0.032, 0.038, 0.0),
    ),
    0.040,
)
_VERTICAL: Final = (0.0, 1.0, 0.0)
ARM: Final = Loft(
    (0.130, 1.378, -0.010),
    (0.690, 1.380, -0.010),
    _VERTICAL,
    (
        (0.000, 0.044, 0.045, 0.045, 0.0),
        (0.100, 0.045, 0.044, 0.044, 0.0),
        (0.220, 0.042, 0.042, 0.043, 0.0),
        (0.350, 0.038, 0.039, 0.039, 0.0),
        (0.470, 0.032, 0.034, 0.034, 0.0),
        (0.536, 0.031, 0.033, 0.034, 0.0),
        (0.610, 0.034, 0.037, 0.036, 0.0),
        (0.740, 0.030, 0.033, 0.032, 0.0),
        (0.880, 0.021, 0.025, 0.024, 0.0),
        (1.000, 0.018, 0.025, 0.024, 0.0),
    ),
    0.050,
)
PALM: Final = Loft(
    (0.680, 1.380, -0.010),
    (0.765, 1.377, -0.008),
    _VERTICAL,
    (
        (0.00, 0.018, 0.025, 0.024, 0.0),
        (0.45, 0.018, 0.037, 0.034, 0.0),
        (1.00, 0.014, 0.039, 0.037, 0.0),
    ),
    0.018,
)
FINGERS: Final = Loft(
    (0.765, 1.377, -0.008),
    (0.850, 1.362, -0.008),
    _VERTICAL,
    (
        (0.00, 0.013, 0.038, 0.036, 0.0),
        (0.40, 0.011, 0.033, 0.031, 0.0),
        (1.00, 0.0075, 0.015, 0.015, 0.0),
    ),
    0.010,
)
THUMB: Final = Loft(
    (0.700, 1.374, 0.012),
    (0.772, 1.362, 0.060),
    _VERTICAL,
    ((0.0, 0.014, 0.014, 0.014, 0.0), (0.5, 0.012, 0.012, 0.012, 0.0), (1.0, 0.008, 0.008, 0.008, 0.0)),
    0.014,
)
FOOT: Final = Loft(
    (0.090, 0.052, 0.000),
    (0.092, 0.022, 0.130),
    (1.0, 0.0, 0.0),
    (
        (0.00, 0.030, 0.040, 0.052, 0.0),
        (0.40, 0.034, 0.034, 0.038, 0.0),
        (0.80, 0.042, 0.023, 0.028, 0.0),
        (1.00, 0.043, 0.018, 0.022, 0.0),
    ),
    0.030,
)
TOES: Final = Loft(
    (0.092, 0.020, 0.128),
    (0.088, 0.013, 0.180),
    (1.0, 0.0, 0.0),
    ((0.0, 0.043, 0.018, 0.020, 0.0), (0.5, 0.040, 0.014, 0.016, 0.0), (1.0, 0.024, 0.010, 0.012, 0.0)),
    0.012,
)

CHEST: Final = Ellipsoid((0.060, 1.250, 0.058), (0.064, 0.058, 0.048), 0.050)
SEAT: Final = Ellipsoid((0.072, 0.872, -0.058), (0.078, 0.084, 0.062), 0.050)
DELTOID: Final = Ellipsoid((0.168, 1.380, -0.010), (0.050, 0.045, 0.049), 0.045)
HEEL: Final = Ellipsoid((0.090, 0.036, -0.026), (0.031, 0.038, 0.040), 0.030)

BODY: Final[tuple[Loft | Ellipsoid, ...]] = (
    TORSO,
    CHEST,
    SEAT,
    NECK,
    Loft(  # trapezius: from the neck to the shoulder
        (0.020, 1.440, -0.026),
        (0.142, 1.392, -0.014),
        _VERTICAL,
        ((0.0, 0.032, 0.032, 0.032, 0.0), (1.0, 0.024, 0.030, 0.032, 0.0)),
        0.045,
    ),
    DELTOID,
    ARM,
    PALM,
    FINGERS,
    THUMB,
    LEG,
    Ellipsoid((0.0, 0.842, 0.006), (0.075, 0.040, 0.062), 0.040),  # between the legs
    HEEL,
    FOOT,
    TOES,
    # a head for far away (near ones are meshes of their own): skull, face, chin, nose
    Ellipsoid((0.0, 1.622, -0.006), (0.0735, 0.078, 0.0935), 0.015),
    Ellipsoid((0.0, 1.570, 0.030), (0.054, 0.074, 0.056), 0.035),
    Ellipsoid((0.0, 1.507, 0.058), (0.028, 0.020, 0.028), 0.035),
    Ellipsoid((0.0, 1.572, 0.088), (0.009, 0.024, 0.014), 0.020, 14.0),
)
"""The left half of the body, in blending order."""


def _ellipsoid_distance(part: Ellipsoid, points: Float64) -> Float64:
    local = points - np.array(part.centre)
    if part.pitch_deg:
        c, s = np.cos(np.deg2rad(part.pitch_deg)), np.sin(np.deg2rad(part.pitch_deg))
        local = np.stack([local[:, 0], c * local[:, 1] - s * local[:, 2], s * local[:, 1] + c * local[:, 2]], axis=1)
    return _scaled_distance(local / np.array(part.radii), np.array(part.radii)[None, :])


def _scaled_distance(unit: Float64, radii: Float64) -> Float64:
    """Return the approximate distance to an ellipsoid with the surface |unit| = 1 (first order)."""
    k0 = np.sqrt((unit * unit).sum(axis=1))
    k1 = np.sqrt(((unit / radii) ** 2).sum(axis=1))
    return np.asarray(k0 * (k0 - 1.0) / np.maximum(k1, _TINY))


@dataclass(frozen=True, slots=True, eq=False)
class _LoftTable:
    """A loft prepared for evaluation: frame, length, and rows sampled densely from a monotone cubic spline."""

    start: Float64
    axes: Float64  # rows: along, across, front
    length: float
    samples: Float64  # (_SAMPLES, 4): across, front, back, shift
    blend: float


def _prepare(loft: Loft) -> _LoftTable:
    from scipy.interpolate import PchipInterpolator  # not at the top: a body of the cache does without (0.4 s)

    start, end = np.array(loft.start), np.array(loft.end)
    length = float(np.linalg.norm(end - start))
    along = (end - start) / length
    across = np.array(loft.across) - along * float(np.dot(loft.across, along))
    across /= np.linalg.norm(across)
    front = np.cross(across, along)
    if abs(front[2]) > abs(front[1]):
        front *= np.sign(front[2])  # limbs: the front is where the body faces
    else:
        front *= np.sign(front[1])  # feet: the front is the instep
    rows = np.array(loft.rows)
    samples = PchipInterpolator(rows[:, 0], rows[:, 1:])(np.linspace(0.0, 1.0, _SAMPLES))
    return _LoftTable(start, np.stack([along, across, front]), length, samples, loft.blend)


def _loft_distance(table: _LoftTable, points: Float64) -> Float64:
    local = (points - table.start) @ table.axes.T
    place = np.clip(local[:, 0] / table.length, 0.0, 1.0) * (_SAMPLES - 1)
    low = np.minimum(place.astype(np.int64), _SAMPLES - 2)
    part = (place - low)[:, None]
    row = table.samples[low] * (1.0 - part) + table.samples[low + 1] * part
    beyond = local[:, 0] - np.clip(local[:, 0], 0.0, table.length)
    front = local[:, 2] - row[:, 3]
    thick = np.where(front > 0.0, row[:, 1], row[:, 2])
    radii = np.stack([np.minimum(row[:, 0], thick), row[:, 0], thick], axis=1)
    return _scaled_distance(np.stack([beyond, local[:, 1], front], axis=1) / radii, radii)


def _blend(a: Float64, b: Float64, width: float) -> Float64:
    """Return the smooth minimum: the union of two shapes with a fillet `width` [m] wide."""
    if width <= 0.0:
        return np.minimum(a, b)
    overlap = np.maximum(width - np.abs(a - b), 0.0) / width
    return np.minimum(a, b) - overlap * overlap * width * 0.25


class Shape:
    """Distance field of a list of parts, evaluated for many points at once."""

    def __init__(self, parts: tuple[Loft | Ellipsoid, ...]) -> None:
        self._parts = [(part if isinstance(part, Ellipsoid) else _prepare(part)) for part in parts]

    def distance(self, points: Float64) -> Float64:
        """Return the approximate distance from the skin [m], negative inside; points (N, 3) in the rest pose."""
        mirrored = points.copy()
        mirrored[:, 0] = np.abs(mirrored[:, 0])
        total: Float64 | None = None
        for part in self._parts:
            if isinstance(part, Ellipsoid):
                distance = _ellipsoid_distance(part, mirrored)
            else:
                distance = _loft_distance(part, mirrored)
            total = distance if total is None else _blend(total, distance, part.blend)
        if total is None:
            raise ValueError("a shape needs at least one part")
        return np.maximum(total, -points[:, 1])  # soles are flat

    def normal(self, points: Float64, step: float = 2e-3) -> Float64:
        """Return unit outward normals (N, 3) from central differences over `step` [m]."""
        moved = np.concatenate([points + step * axis for axis in _STEPS])
        values = self.distance(moved).reshape(6, -1)
        gradient = np.stack([values[0] - values[1], values[2] - values[3], values[4] - values[5]], axis=1)
        return np.asarray(gradient / np.maximum(np.linalg.norm(gradient, axis=1, keepdims=True), _TINY))


_STEPS: Final = np.array(
    [[1.0, 0, 0], [-1.0, 0, 0], [0, 1.0, 0], [0, -1.0, 0], [0, 0, 1.0], [0, 0, -1.0]], dtype=np.float64
)
