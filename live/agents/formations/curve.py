"""A line on the floor, measured along its way, on which dancers can be placed (T090)."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]

CORNER: Final = math.radians(28.0)
"""A line that turns more than this in one point has a corner there."""

FREE: Final = 0.0
"""Gap, in spacings, between the end of a line and its first dancer: she stands on the end."""
HALF: Final = 0.5
"""The end lies on a symmetry line: the reflected dancer is a whole spacing away."""
MEETS: Final = 0.75
"""The end lies on another line, whose dancers keep the place."""
SHARED: Final = 1.0
"""The end lies where a dancer stands already."""


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A line of P points; `at` says how far along it each is, in metres, or in mass where dancers are weighted."""

    points: Float64
    """Shape (P, 2) [m]; a closed line ends in its first point."""
    at: Float64
    """Shape (P,), growing from 0."""
    closed: bool
    corners: tuple[float, ...] = ()
    """Where along it the corners are, in units of `at`; ends of open lines are none."""
    gaps: tuple[float, float] = (FREE, FREE)
    """FREE, HALF, MEETS or SHARED, for both ends of an open line."""
    marked: bool = True
    """Whether its corners may be places that are taken first."""

    @property
    def length(self) -> float:
        """The whole way, in units of `at`."""
        return float(self.at[-1])

    def place(self, at: Float64) -> Float64:
        """Points at `at` (K,), shape (K, 2); a closed line goes on at its start."""
        at = np.mod(at, self.length) if self.closed and self.length > 0 else at
        return np.stack([np.interp(at, self.at, self.points[:, 0]), np.interp(at, self.at, self.points[:, 1])], axis=1)

    def tangent(self, at: Float64) -> Float64:
        """Unit vectors along the line at `at` (K,), shape (K, 2); on a corner along the way that leaves it."""
        at = np.mod(at, self.length) if self.closed and self.length > 0 else at
        piece = np.clip(np.searchsorted(self.at, at, side="right") - 1, 0, len(self.at) - 2)
        way = self.points[piece + 1] - self.points[piece]
        return np.asarray(way / np.maximum(np.hypot(way[:, 0], way[:, 1]), 1e-12)[:, None])


def curve_of(points: Float64, *, closed: bool) -> Curve | None:
    """The line through `points` (P, 2), measured, its corners found; None if it has no length."""
    if closed and len(points) and np.hypot(*(points[0] - points[-1])) > 1e-9:
        points = np.concatenate([points, points[:1]])
    if len(points) < 2:
        return None
    steps = np.hypot(*np.diff(points, axis=0).T)
    kept = np.concatenate([[True], steps > 1e-9])
    points = np.ascontiguousarray(points[kept], np.float64)
    at = np.concatenate([[0.0], np.cumsum(steps[kept[1:]])])
    if len(points) < 2 or at[-1] < 1e-6:
        return None
    return Curve(points, at, closed, tuple(float(each) for each in at[_corners(points, closed)]))


def _corners(points: Float64, closed: bool) -> npt.NDArray[np.int64]:
    """Indices of the points in which the line turns sharply; ends of an open line are none."""
    way = np.diff(points, axis=0)
    heading = np.arctan2(way[:, 1], way[:, 0])
    if closed:
        heading = np.concatenate([heading[-1:], heading])
    turn = np.abs(np.mod(np.diff(heading) + math.pi, 2.0 * math.pi) - math.pi)
    return np.flatnonzero(turn > CORNER) + (0 if closed else 1)


def begin_at(curve: Curve, at: float) -> Curve:
    """The same closed line, begun at `at` [m along it]."""
    at = math.fmod(at, curve.length)
    if at < 1e-9 or curve.length - at < 1e-9:
        return curve
    ahead = curve.at > at + 1e-9
    start = curve.place(np.array([at]))
    turned = np.concatenate([start, curve.points[ahead], curve.points[1:][~ahead[1:]], start])
    again = curve_of(turned, closed=True)
    return curve if again is None else again
