"""Where dancers of a formation face (T090, T102): the public, the middle, outwards, along the line, or an angle."""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import shapely

from live.agents.formations.curve import Curve
from live.agents.formations.spec import FormationSpec

Float64 = npt.NDArray[np.float64]


def headings(
    spec: FormationSpec, places: Float64, ways: Float64 | None, middle: Float64, curves: Sequence[Curve]
) -> Float64:
    """Heading of each of the places (S, 2) [rad], in [-π, π), shape (S,).

    `ways` (S, 2) are unit vectors along the lines, None for dancers inside: they face along the nearest line.
    Who stands in the very middle faces the public.
    """
    if spec.heading == "public" or not len(places):
        return np.zeros(len(places))
    if spec.heading == "angle":
        return np.full(len(places), _wrapped(np.array(math.radians(spec.heading_deg))))
    if spec.heading == "along":
        way = _nearest_ways(places, curves) if ways is None else ways
    else:
        way = middle - places if spec.heading == "centre" else places - middle
        way = np.where((np.hypot(way[:, 0], way[:, 1]) < 1e-6)[:, None], np.array([0.0, 1.0]), way)
    return _wrapped(np.arctan2(way[:, 0], way[:, 1]))


def _wrapped(angle: Float64) -> Float64:
    return np.asarray(np.mod(angle + math.pi, 2.0 * math.pi) - math.pi)


def _nearest_ways(places: Float64, curves: Sequence[Curve]) -> Float64:
    """Unit vectors along the line nearest to each of the places, shape (S, 2)."""
    points = shapely.points(places)
    drawn = np.array([shapely.LineString(curve.points) for curve in curves])
    nearest = np.argmin([shapely.distance(line, points) for line in drawn], axis=0)
    ways = np.zeros_like(places)
    for n, curve in enumerate(curves):
        own = nearest == n
        at = shapely.line_locate_point(drawn[n], points[own])
        ways[own] = curve.tangent(np.asarray(at, np.float64))
    return ways
