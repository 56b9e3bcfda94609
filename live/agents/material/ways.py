"""Ways of dancers as curves with few points, and their transformation: evolutions as material (T145, T146).

A way is a cubic spline through its points at even times: of two points a straight line, of one a place.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from live.agents.material.transform import Transform, map_points, transform_group
from live.base.arrays import Float32, Float64

MOST_POINTS: Final = 129
"""Most points of a fitted way."""
COUNTS: Final = (1, 2, 3, 4, 5, 6, 7, 9, 11, 13, 17, 21, 25, 33, 41, 49, 65, 81, 97, MOST_POINTS)
"""Numbers of points that are tried."""
TOLERANCE: Final = 0.05
"""A fitted way leaves the recorded one by at most so much [m], if `MOST_POINTS` suffice."""
KNOTS_PER_POINT: Final = 16
"""Knots of a danced way between two of its points."""
KNOTS: Final = (65, 1025)
"""Fewest and most knots of a danced way."""
MOST_MOMENTS: Final = 65
"""Most moments at which neighbours and distances are looked at."""

MOST_BENDS: Final = 13
"""Most points of the curve by which a way is displaced."""

UNCHANGED: Final = Transform()

Way = tuple[tuple[float, float], ...]


@lru_cache(maxsize=256)
def way_basis(points: int, moments: int) -> Float64:
    """Return the matrix (moments, points) that makes places at even times of the points of a way."""
    from scipy.interpolate import CubicSpline

    if points == 1:
        return np.ones((moments, 1))
    spline = CubicSpline(np.linspace(0.0, 1.0, points), np.eye(points))
    basis = np.asarray(spline(np.linspace(0.0, 1.0, moments)), np.float64)
    basis.setflags(write=False)
    return basis


def sample_ways(ways: Sequence[Way], moments: int) -> Float64:
    """Return the places of D ways at even times, (moments, D, 2) [m]."""
    if not ways:
        return np.zeros((moments, 0, 2))
    return np.stack([way_basis(len(way), moments) @ np.array(way, np.float64) for way in ways], axis=1)


@dataclass(frozen=True, slots=True)
class FittedWays:
    """Ways with few points that follow recorded ones."""

    ways: tuple[Way, ...]
    error: float
    """Greatest distance from the recorded places [m]."""


def fit_ways(places: Float64, tolerance: float = TOLERANCE) -> FittedWays:
    """Return ways of as few points as follow recorded `places` (S, D, 2) [m] at even times within `tolerance` [m].

    Each begins and ends where the recorded one does. Points are rounded to centimetres.
    """
    moments, count = places.shape[:2]
    found: list[Way] = [()] * count
    errors = np.full(count, np.inf)
    for points in COUNTS:
        left = np.flatnonzero(errors > tolerance)
        if not len(left) or (points > moments and points > 2):
            break
        fitted, error = _fitted(places[:, left], points)
        better = error < errors[left]
        for row in np.flatnonzero(better):
            found[left[row]] = tuple((round(float(x), 2), round(float(z), 2)) for x, z in fitted[:, row])
        errors[left[better]] = error[better]
    return FittedWays(tuple(found), float(errors.max(initial=0.0)))


def _fitted(places: Float64, points: int) -> tuple[Float64, Float64]:
    """Return the points (points, D, 2) of ways with fixed ends that fit places (S, D, 2) best, and the error of each,
    (D,) [m]."""
    basis = way_basis(points, len(places))
    if points == 1:
        made = (places.min(axis=0, keepdims=True) + places.max(axis=0, keepdims=True)) / 2.0
    else:
        made = np.concatenate([places[:1], np.zeros((points - 2, *places.shape[1:])), places[-1:]])
        rest = places - np.einsum("sc,cdk->sdk", basis, made)
        if points > 2:
            inner = np.linalg.lstsq(basis[:, 1:-1], rest.reshape(len(places), -1), rcond=None)[0]
            made[1:-1] = inner.reshape(points - 2, *places.shape[1:])
    made = np.round(made, 2)
    return made, np.hypot(*np.moveaxis(np.einsum("sc,cdk->sdk", basis, made) - places, 2, 0)).max(axis=0)


def transform_ways(transform: Transform, ways: Sequence[Way]) -> tuple[Way, ...]:
    """Return the ways of a group transformed. PersonError if the transformation does not suit the group.

    Where lines stay lines and nobody comes too near, every way keeps its number of points.
    """
    points = max(map(len, ways), default=1)
    moments = 1 if points == 1 else min(2 * points + 5, MOST_MOMENTS)
    together = sample_ways(ways, points)
    source = np.einsum("sc,cdk->sdk", way_basis(points, moments), together)
    bends = min(points, MOST_BENDS)
    coarse = None if points == 1 else (way_basis(bends, moments), way_basis(bends, points))
    found = transform_group(transform, together, way_basis(points, moments), coarse)
    exact = map_points(transform, together, source)[0]
    if transform.is_exact and np.array_equal(found.points, exact):
        mapped = [map_points(transform, np.array(way, np.float64)[:, None], source)[0][:, 0] for way in ways]
        return tuple(tuple((float(x), float(z)) for x, z in way) for way in mapped)
    return tuple(tuple((float(x), float(z)) for x, z in way) for way in np.moveaxis(found.points, 1, 0))


@dataclass(frozen=True, slots=True)
class Material:
    """An evolution as material: written ways, or another one's transformed."""

    ways: tuple[Way, ...] = ()
    like: "Material | None" = None
    transform: Transform = UNCHANGED


@lru_cache(maxsize=512)
def ways_of(material: Material) -> tuple[Way, ...]:
    """Return the ways of an evolution. PersonError if a transformation does not suit the group."""
    return material.ways if material.like is None else transform_ways(material.transform, ways_of(material.like))


@lru_cache(maxsize=512)
def danced_ways(material: Material) -> Float32:
    """Return the ways of an evolution as knots at even times, (D, K, 2) [m]."""
    ways = ways_of(material)
    wanted = KNOTS_PER_POINT * (max(map(len, ways), default=1) - 1) + 1
    knots = KNOTS[0]
    while knots < min(wanted, KNOTS[1]):
        knots = 2 * knots - 1
    found = np.ascontiguousarray(np.moveaxis(sample_ways(ways, knots), 1, 0), np.float32)
    found.setflags(write=False)
    return found
