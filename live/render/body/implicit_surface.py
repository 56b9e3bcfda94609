"""Implicit surfaces: smoothly blended lofts and ellipsoids, and hollows.

The field is zero on the skin, positive outside, about the distance [m] near it. A body is symmetric, so only the left
half is described (left = +x) and points are mirrored into it.
"""

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.motion.curve import hermite, monotone_slopes
from live.render.body.implicit_surface_kernels import COLUMNS, FIRST, SAMPLES, distances, first_outside

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


def _cross_sections(rows: Float64) -> Float64:
    """Return the cross-sections of a loft at SAMPLES places (SAMPLES, 4), between its rows (N, 5) on a monotone cubic
    (Fritsch and Butland 1984): scipy's PchipInterpolator, which takes 0.4 s to import."""
    place, values = rows[:, 0], rows[:, 1:]
    step = np.diff(place)
    rate = np.diff(values, axis=0) / step[:, None]
    slopes = monotone_slopes(place, values)
    if len(rows) == 2:
        slopes[:] = rate
    else:
        slopes[0] = _end_slope(step[0], step[1], rate[0], rate[1])
        slopes[-1] = _end_slope(step[-1], step[-2], rate[-1], rate[-2])
    return np.asarray(hermite(place, values, slopes, np.linspace(0.0, 1.0, SAMPLES)))


def _end_slope(near_step: float, far_step: float, near: Float64, far: Float64) -> Float64:
    """Return the slopes at an end: of the parabola through the three points next to it, unless that overshoots."""
    slope = ((2.0 * near_step + far_step) * near - near_step * far) / (near_step + far_step)
    steep = (near * far < 0.0) & (np.abs(slope) > 3.0 * np.abs(near))
    return np.where(slope * near <= 0.0, 0.0, np.where(steep, 3.0 * near, slope))


@cache
def _ellipsoid_row(part: Ellipsoid) -> Float64:
    """Return the row of an ellipsoid in the table of parts."""
    roll, pitch = np.deg2rad(part.roll_deg), np.deg2rad(part.pitch_deg)
    rolled = np.array([[np.cos(roll), np.sin(roll), 0.0], [-np.sin(roll), np.cos(roll), 0.0], [0.0, 0.0, 1.0]])
    pitched = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(pitch), -np.sin(pitch)], [0.0, np.sin(pitch), np.cos(pitch)]])
    centre, radii = np.array(part.centre), np.array(part.radii)
    reach = np.full(3, radii.max()) if part.pitch_deg or part.roll_deg else radii
    axes = pitched @ rolled
    return np.array(
        [part.blend, part.hollow, *(centre - reach), *(centre + reach), *centre, *axes.flat, *1.0 / radii, 0, 0]
    )


@cache
def _loft_row(part: Loft) -> tuple[Float64, Float64]:
    """Return the row of a loft in the table of parts, but for FIRST, and its cross-sections (SAMPLES, 4)."""
    start, end = np.array(part.start), np.array(part.end)
    length = float(np.linalg.norm(end - start))
    along = (end - start) / length
    across = np.array(part.across) - along * float(np.dot(part.across, along))
    across /= np.linalg.norm(across)
    front = np.cross(across, along)
    if abs(front[2]) > abs(front[1]):
        front *= np.sign(front[2])  # limbs: the front is where the body faces
    else:
        front *= np.sign(front[1])  # feet: the front is the instep
    sections = _cross_sections(np.array(part.rows))
    reach = sections[:, :3].max() + np.abs(sections[:, 3]).max()
    low, high = np.minimum(start, end) - reach, np.maximum(start, end) + reach
    axes = (*along, *across, *front)
    return np.array(
        [part.blend, part.hollow, *low, *high, *start, *axes, (SAMPLES - 1) / length, 0.0, 0.0, length, 0.0]
    ), sections


class Shape:
    """Distance field of a list of parts, evaluated for many points at once."""

    def __init__(self, parts: tuple[Loft | Ellipsoid, ...]) -> None:
        if not parts:
            raise ValueError("a shape needs at least one part")
        rows, sections = np.empty((len(parts), COLUMNS)), [np.empty((0, 4))]
        for row, part in zip(rows, parts, strict=True):
            if isinstance(part, Ellipsoid):
                row[:] = _ellipsoid_row(part)
            else:
                row[:], section = _loft_row(part)
                row[FIRST] = SAMPLES * (len(sections) - 1)
                sections.append(section)
        self._parts, self._sections = rows, np.concatenate(sections)

    def distance(self, points: Float64) -> Float64:
        """Return the approximate distance from the skin [m], negative inside; points (N, 3) in the rest pose."""
        out = np.empty(len(points))
        distances(np.ascontiguousarray(points, np.float64), self._parts, self._sections, out)
        return out

    def first_outside(self, origins: Float64, way: Float64, reach: Float64) -> Int64:
        """Return which of the places `reach` (K,) [m] along a ray is the first outside, the last one if none is, (N,);
        the rays begin at origins (N, 3) and go along the unit vector `way` (3,)."""
        out = np.empty(len(origins), np.int64)
        origins, way = np.ascontiguousarray(origins), np.ascontiguousarray(way)
        first_outside(origins, way, reach, self._parts, self._sections, out)
        return out

    def normal(self, points: Float64, step: float = 2e-3) -> Float64:
        """Return unit outward normals (N, 3) from central differences over `step` [m]."""
        moved = np.concatenate([points + step * axis for axis in _STEPS])
        values = self.distance(moved).reshape(6, -1)
        gradient = np.stack([values[0] - values[1], values[2] - values[3], values[4] - values[5]], axis=1)
        return np.asarray(gradient / np.maximum(np.linalg.norm(gradient, axis=1, keepdims=True), _TINY))


_STEPS: Final = np.array(
    [[1.0, 0, 0], [-1.0, 0, 0], [0, 1.0, 0], [0, -1.0, 0], [0, 0, 1.0], [0, 0, -1.0]], dtype=np.float64
)
