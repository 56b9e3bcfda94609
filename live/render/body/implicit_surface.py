"""Implicit surfaces: smoothly blended lofts and ellipsoids, and hollows.

The field is zero on the skin, positive outside, about the distance [m] near it. A body is symmetric, so only the left
half is described (left = +x) and points are mirrored into it.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64

_SAMPLES: Final = 65
_TINY: Final = 1e-9


@dataclass(frozen=True, slots=True)
class Ellipsoid:
    """An ellipsoid: centre, radii, and blend width with the parts before it [m]; `pitch_deg` rotates it about x, after
    `roll_deg` about z. A hollow one is cut out of the parts before it."""

    centre: tuple[float, float, float]
    radii: tuple[float, float, float]
    blend: float
    pitch_deg: float = 0.0
    roll_deg: float = 0.0
    hollow: bool = False


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
    hollow: bool = False


def upright(x: float, z: float, rows: tuple[tuple[float, float, float, float, float], ...], blend: float) -> Loft:
    """Return a vertical loft whose rows have heights y [m] from the top down instead of t."""
    top, bottom = rows[0][0], rows[-1][0]
    scaled = tuple(((top - y) / (top - bottom), *rest) for y, *rest in rows)
    return Loft((x, top, z), (x, bottom, z), (1.0, 0.0, 0.0), scaled, blend)  # type: ignore[arg-type]


def _ellipsoid_distance(part: Ellipsoid, points: Float64) -> Float64:
    local = points - np.array(part.centre)
    if part.roll_deg:
        c, s = np.cos(np.deg2rad(part.roll_deg)), np.sin(np.deg2rad(part.roll_deg))
        local = np.stack([c * local[:, 0] + s * local[:, 1], c * local[:, 1] - s * local[:, 0], local[:, 2]], axis=1)
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
    hollow: bool


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
    return _LoftTable(start, np.stack([along, across, front]), length, samples, loft.blend, loft.hollow)


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


def _box(part: Ellipsoid | _LoftTable) -> Float64:
    """Return a box around a part, shape (2, 3): lowest and highest x, y, z [m]."""
    if isinstance(part, Ellipsoid):
        turned = part.pitch_deg or part.roll_deg
        reach = np.full(3, max(part.radii)) if turned else np.array(part.radii)
        return np.array([part.centre - reach, part.centre + reach])
    end = part.start + part.axes[0] * part.length
    reach = part.samples[:, :3].max() + np.abs(part.samples[:, 3]).max()
    return np.array([np.minimum(part.start, end) - reach, np.maximum(part.start, end) + reach])


class Shape:
    """Distance field of a list of parts, evaluated for many points at once."""

    def __init__(self, parts: tuple[Loft | Ellipsoid, ...]) -> None:
        self._parts = [(part if isinstance(part, Ellipsoid) else _prepare(part)) for part in parts]
        self._boxes = [_box(part) for part in self._parts]
        if not parts:
            raise ValueError("a shape needs at least one part")

    def distance(self, points: Float64) -> Float64:
        """Return the approximate distance from the skin [m], negative inside; points (N, 3) in the rest pose."""
        mirrored = points.copy()
        mirrored[:, 0] = np.abs(mirrored[:, 0])
        total = np.full(len(points), np.inf)
        for part, (low, high) in zip(self._parts, self._boxes, strict=True):
            beyond = np.linalg.norm(np.maximum(np.maximum(low - mirrored, mirrored - high), 0.0), axis=1)
            # a part whose box is farther than what is there changes nothing
            near = np.flatnonzero(beyond < (part.blend + 1e-3 if part.hollow else total + part.blend))
            here = mirrored[near]
            own = _ellipsoid_distance(part, here) if isinstance(part, Ellipsoid) else _loft_distance(part, here)
            if part.hollow:
                total[near] = -_blend(-total[near], own, part.blend)
            else:
                total[near] = _blend(total[near], own, part.blend)
        return np.asarray(np.maximum(total, -points[:, 1]))  # soles are flat

    def normal(self, points: Float64, step: float = 2e-3) -> Float64:
        """Return unit outward normals (N, 3) from central differences over `step` [m]."""
        moved = np.concatenate([points + step * axis for axis in _STEPS])
        values = self.distance(moved).reshape(6, -1)
        gradient = np.stack([values[0] - values[1], values[2] - values[3], values[4] - values[5]], axis=1)
        return np.asarray(gradient / np.maximum(np.linalg.norm(gradient, axis=1, keepdims=True), _TINY))


_STEPS: Final = np.array(
    [[1.0, 0, 0], [-1.0, 0, 0], [0, 1.0, 0], [0, -1.0, 0], [0, 0, 1.0], [0, 0, -1.0]], dtype=np.float64
)
