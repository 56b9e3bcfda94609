"""Square lattices inside a region, straight or diagonal, with exact counts (T091, Fig 4.5 a and b).

The count of a symmetrical lattice changes by several dancers at once with its spacing. So many offsets are tried, and
the widest spacing with the exact count is taken.
"""

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import shapely

from live.agents.formations.blue_noise_kernels import lattice_points_in_polygon
from live.base.arrays import Float64

_DEPTH_OFFSETS: Final = (0.0, 0.5, 0.25, 0.75, 0.125, 0.375, 0.625, 0.875)
_ASYMMETRIC_OFFSETS: Final = ((0.31, 0.0), (0.17, 0.5), (0.31, 0.22), (0.17, 0.61), (0.42, 0.37), (0.08, 0.83))
"""Asymmetrical offsets, tried when no symmetrical one gives the right count."""
_CENTRED_ADVANTAGE: Final = 1.03
"""Factor by which another lattice must be wider than one that is also symmetrical from front to back."""
_SWEEP_STEPS: Final = 40
_BISECTIONS: Final = 10


@dataclass(frozen=True, slots=True, eq=False)
class _LatticeRegion:
    """A region in the lattice's axes, and scratch data of the kernel."""

    edges: Float64
    bounds: Float64
    crossings: Float64
    area: float
    diagonal: bool

    def count(self, offset: tuple[float, float], spacing: float, out: Float64) -> int:
        """Return the number of places; write as many as fit into `out`."""
        step = spacing * math.sqrt(2.0) if self.diagonal else spacing
        x0, z0 = offset[0] * step, offset[1] * step
        found = int(lattice_points_in_polygon(self.edges, self.bounds, step, step, x0, z0, self.crossings, out))
        if self.diagonal:  # a second straight lattice between the rows of the first
            rest = out[min(found, len(out)) :]
            x0, z0 = x0 + 0.5 * step, z0 + 0.5 * step
            found += int(lattice_points_in_polygon(self.edges, self.bounds, step, step, x0, z0, self.crossings, rest))
        return found


def place_on_lattice(
    region: Any, count: int, origin: Float64, yaw: float, *, diagonal: bool, symmetrical: bool = False
) -> Float64 | None:
    """Return `count` places of a square lattice in a region, front rows first, shape (count, 2), or None.

    The lattice is symmetrical about the line through `origin` along z turned by `yaw`, if possible; a diagonal one is
    turned by another 45 degrees. With `symmetrical` no asymmetrical lattice is tried.
    """
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    ground = _lattice_region(region, origin, turn, diagonal)
    across = (0.0,) if diagonal else (0.0, 0.5)
    offsets = [(a, b) for b in _DEPTH_OFFSETS for a in across]
    best = _widest_exact(ground, count, offsets)
    if best is None and not symmetrical:
        best = _widest_exact(ground, count, list(_ASYMMETRIC_OFFSETS))
    if best is None:
        best = _widest_trimmed(ground, count, offsets, symmetrical)
    if best is None:
        return None
    order = np.lexsort((np.round(best[:, 0], 9), np.round(-best[:, 1], 9)))
    return np.asarray(best[order] @ turn + origin)


def _lattice_region(region: Any, origin: Float64, turn: Float64, diagonal: bool) -> _LatticeRegion:
    sides = []
    for part in shapely.get_parts(region):
        for ring in (part.exterior, *part.interiors):
            points = (shapely.get_coordinates(ring) - origin) @ turn.T
            sides.append(np.concatenate([points[:-1], points[1:]], axis=1))
    edges = np.ascontiguousarray(np.concatenate(sides))
    bounds = np.array([edges[:, 1].min(), edges[:, 1].max()])
    return _LatticeRegion(edges, bounds, np.zeros(len(edges)), float(region.area), diagonal)


def _widest_exact(ground: _LatticeRegion, count: int, offsets: list[tuple[float, float]]) -> Float64 | None:
    """Return the places of the exact lattice with the widest spacing over all offsets."""
    best, chosen = 0.0, None
    for offset in offsets:
        spacing = _exact_spacing(ground, count, offset)
        worth = 0.0 if spacing is None else spacing * (_CENTRED_ADVANTAGE if offset[1] in (0.0, 0.5) else 1.0)
        if spacing is not None and worth > best * (1.0 + 1e-9):
            best, chosen = worth, (offset, spacing)
    if chosen is None:
        return None
    out = np.zeros((count, 2))
    ground.count(chosen[0], chosen[1], out)
    return out


def _exact_spacing(ground: _LatticeRegion, count: int, offset: tuple[float, float]) -> float | None:
    """Return a spacing that gives exactly `count` places, among the widest such spacings, or None."""
    nothing = np.zeros((0, 2))
    middle = math.sqrt(ground.area / count)
    wide, narrow = (2.2, 0.4) if count < 12 else (1.4, 0.75)
    before = middle * wide
    for spacing in middle * np.geomspace(wide, narrow, _SWEEP_STEPS):
        held = ground.count(offset, float(spacing), nothing)
        if held == count:
            return float(spacing)
        if held > count:
            return _bisect_spacing(ground, count, offset, before, float(spacing))
        before = float(spacing)
    return None


def _bisect_spacing(
    ground: _LatticeRegion, count: int, offset: tuple[float, float], wide: float, narrow: float
) -> float | None:
    """Return an exact spacing between one with too few and one with too many places, or None."""
    nothing = np.zeros((0, 2))
    for _ in range(_BISECTIONS):
        middle = 0.5 * (wide + narrow)
        held = ground.count(offset, middle, nothing)
        if held == count:
            return middle
        wide, narrow = (middle, narrow) if held < count else (wide, middle)
    return None


def _widest_trimmed(
    ground: _LatticeRegion, count: int, offsets: list[tuple[float, float]], symmetrical: bool
) -> Float64 | None:
    """Return the lattice of the widest spacing with too many places, without places at the back, from the outside in.

    For example, a rectangle with only full rows has no lattice of 97. With `symmetrical`, only pairs and places on the
    symmetry line are removed.
    """
    best, chosen = 0.0, None
    for offset in offsets:
        spacing = _widest_with_room(ground, count, offset)
        if spacing is None or spacing <= best * (1.0 + 1e-9):
            continue
        places = np.zeros((2 * count + 64, 2))
        held = ground.count(offset, spacing, places)
        left = _trim_back(places[:held], count, symmetrical) if held <= len(places) else None
        if left is not None:
            best, chosen = spacing, left
    return chosen


def _widest_with_room(ground: _LatticeRegion, count: int, offset: tuple[float, float]) -> float | None:
    nothing = np.zeros((0, 2))
    wide = math.sqrt(ground.area / count) * 2.2
    for _ in range(_SWEEP_STEPS):
        narrow = wide * 0.95
        if ground.count(offset, narrow, nothing) >= count:
            for _ in range(_BISECTIONS):
                middle = 0.5 * (wide + narrow)
                wide, narrow = (wide, middle) if ground.count(offset, middle, nothing) >= count else (middle, narrow)
            return narrow
        wide = narrow
    return None


def _trim_back(places: Float64, count: int, symmetrical: bool) -> Float64 | None:
    """Return `count` of the places, or None if a symmetrical choice is impossible."""
    excess = len(places) - count
    on_line = np.abs(places[:, 0]) < 1e-6
    from_back = np.lexsort((places[:, 0], -np.round(np.abs(places[:, 0]), 6), np.round(places[:, 1], 6)))
    gone: list[int] = []
    if excess % 2:
        single = [int(n) for n in from_back if on_line[n]] or ([] if symmetrical else [int(from_back[0])])
        if not single:
            return None
        gone.append(single[0])
    for n in from_back:  # a place and its reflection follow each other
        if len(gone) < excess and not on_line[n] and int(n) not in gone:
            gone.append(int(n))
    single = [int(n) for n in from_back if on_line[n] and int(n) not in gone]
    gone += single[: excess - len(gone)]
    return np.delete(places, gone, axis=0)
