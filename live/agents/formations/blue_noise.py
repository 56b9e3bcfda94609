"""Placement inside a region with exact counts: blue noise, or even spacing by Lloyd's method (T091, T144)."""

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np
import shapely

from live.agents.formations.blue_noise_kernels import eliminate, lloyd_relax
from live.agents.formations.symmetry import SymmetryLine
from live.base.arrays import Float64

Density = Callable[[Float64], Float64]

CANDIDATES_PER_DANCER: Final = 5
"""Candidate points per dancer (Yuksel 2015 uses five)."""
MIN_CANDIDATES: Final = 100
GROUND_POINTS_PER_DANCER: Final = 10
MIN_GROUND_POINTS: Final = 1000
LLOYD_ROUNDS: Final = 16
OVER_RELAXATION: Final = 1.8
"""Over-relaxation of Lloyd's method: fewer rounds, same result."""


def scatter(region: Any, count: int, seed: int, *, density: Density | None = None, even: bool = False) -> Float64:
    """Return `count` places in a region, shape (count, 2): Poisson disk by sample elimination, or evenly with `even`.

    `density` returns the relative density at points (K, 2). The same seed gives the same places.
    """
    return _scatter(region, count, float(region.area), seed, density, even, None, np.zeros((0, 2)))


def scatter_mirrored(
    half: Any, line: SymmetryLine, count: int, seed: int, *, density: Density | None = None, even: bool = False
) -> Float64:
    """Return `count` places, symmetrical about `line`, in a half region and its reflection; an odd one lies on the
    line.
    """
    middle = np.zeros((0, 2))
    if count % 2:
        middle = midpoint_on_line(half, line)[None]
    places = _scatter(half, count // 2, 2.0 * float(half.area), seed, density, even, line, middle)
    return np.concatenate([places, middle, line.reflect(places)])


def midpoint_on_line(half: Any, line: SymmetryLine) -> Float64:
    """Return the middle of the longest part of the symmetry line in the region, shape (2,).

    If no part of the line is in the region, return the region's centre projected onto the line.
    """
    low_x, low_z, high_x, high_z = half.bounds
    far = math.hypot(high_x - low_x, high_z - low_z)
    centre = np.array([(low_x + high_x) / 2, (low_z + high_z) / 2])
    foot = line.project(centre[None])[0]
    cut = shapely.LineString([foot - far * line.direction, foot + far * line.direction]).intersection(half.buffer(1e-6))
    parts = [part for part in shapely.get_parts(cut) if part.length > 1e-5]
    if not parts:
        return np.asarray(foot)
    longest = max(parts, key=lambda part: part.length)
    point = shapely.get_coordinates(longest.interpolate(0.5, normalized=True))[0]
    return np.asarray(line.project(point[None])[0])


def hexagonal_spacing(area: float, count: int) -> float:
    """Return the neighbour distance [m] of `count` dancers on a hexagonal lattice, the largest possible."""
    return math.sqrt(2.0 * area / (math.sqrt(3.0) * max(count, 1)))


def _scatter(
    region: Any,
    count: int,
    area: float,
    seed: int,
    density: Density | None,
    even: bool,
    line: SymmetryLine | None,
    fixed: Float64,
) -> Float64:
    """Return `count` places in `region`; `area` [m²] is that of all dancers, reflected ones included."""
    if count == 0:
        return np.zeros((0, 2))
    chance = np.random.default_rng(seed)
    number = max(CANDIDATES_PER_DANCER * count, MIN_CANDIDATES)
    points = _uniform_points(region, number if density is None else 4 * number, chance)
    scale = np.ones(number)
    if density is not None:
        dense = density(points)
        kept = np.sort(chance.choice(len(points), number, replace=False, p=dense / dense.sum()))
        points = points[kept]
        scale = np.sqrt(dense[kept] * (1.0 / np.mean(1.0 / dense[kept])) ** -1)
    people = count if line is None else 2 * count
    reach = hexagonal_spacing(area, people + len(fixed))
    least = 0.5 * reach * (1.0 - (count / number) ** 1.5) * 0.65
    reflected = np.zeros((0, 2)) if line is None else np.ascontiguousarray(line.reflect(points))
    weight = np.zeros(number)
    eliminate(np.ascontiguousarray(points), reflected, np.ascontiguousarray(fixed), scale, count, reach, least, weight)
    places = points[weight >= 0.0]
    return _relax(region, places, fixed, density, chance) if even else places


def _uniform_points(region: Any, number: int, rng: np.random.Generator) -> Float64:
    """Return `number` points, uniform over the region, however thin it is, shape (number, 2)."""
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(region))
    corners = shapely.get_coordinates(triangles).reshape(-1, 4, 2)[:, :3]
    share = np.cumsum(shapely.area(triangles))
    drawn = rng.random((number, 3))
    picked = np.minimum(np.searchsorted(share, drawn[:, 0] * share[-1], side="right"), len(share) - 1)
    root = np.sqrt(drawn[:, 1])
    weights = np.stack([1.0 - root, root * (1.0 - drawn[:, 2]), root * drawn[:, 2]], axis=1)
    return np.asarray((weights[:, :, None] * corners[picked]).sum(axis=1))


def _relax(region: Any, places: Float64, fixed: Float64, density: Density | None, rng: np.random.Generator) -> Float64:
    """Relax the places until each has about the same share of the region; those that end outside move back in."""
    ground = np.ascontiguousarray(
        _ground_points(region, max(GROUND_POINTS_PER_DANCER * len(places), MIN_GROUND_POINTS), rng)
    )
    dense = np.ones(len(ground)) if density is None else np.ascontiguousarray(density(ground))
    sites = np.concatenate([places, fixed])
    nearest = np.zeros(len(ground), np.int64)
    lloyd_relax(ground, dense, sites, len(places), LLOYD_ROUNDS, OVER_RELAXATION, np.zeros((len(sites), 3)), nearest)
    outside = ~shapely.intersects_xy(region, sites[: len(places), 0], sites[: len(places), 1])
    for n in np.flatnonzero(outside):
        own = ground[nearest == n]
        own = own if len(own) else ground
        sites[n] = own[np.argmin(((own - sites[n]) ** 2).sum(axis=1))]
    return np.asarray(sites[: len(places)])


def _ground_points(region: Any, number: int, rng: np.random.Generator) -> Float64:
    """Return about `number` points all over the region: a fine grid, or random points where the region is too thin."""
    low_x, low_z, high_x, high_z = region.bounds
    pitch = math.sqrt(region.area / number)
    columns, rows = math.ceil((high_x - low_x) / pitch), math.ceil((high_z - low_z) / pitch)
    if columns * rows > 20 * number:
        return _uniform_points(region, number, rng)
    x = low_x + (np.arange(columns) + 0.5) * (high_x - low_x) / columns
    z = low_z + (np.arange(rows) + 0.5) * (high_z - low_z) / rows
    grid = np.stack(np.meshgrid(x, z), axis=-1).reshape(-1, 2)
    inside = grid[shapely.contains_xy(region, grid[:, 0], grid[:, 1])]
    return inside if len(inside) > number / 2 else _uniform_points(region, number, rng)
