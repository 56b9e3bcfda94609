"""Transformations of a group's places and ways: scale, turn, mirror, bend, along a line, into a region (T145, T146).

Scaling, turning, moving and mirroring are exact. The others are a map of the floor first, and then a deformation that
keeps neighbours and bodies apart (`deformation.py`).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from live.agents.groups.roster import Line, mirror_places
from live.agents.material.deformation import EASY_GAP, WANTED_SHARE, Deformation, Deformed, fitted_into
from live.agents.material.room import BODY_RADIUS, LEAST_GAP, Rings, Room, room_of
from live.base.arrays import Float64
from live.base.errors import PersonError

Point = tuple[float, float]
DEEPEST_BEND: Final = 0.8
"""Greatest depth of a group in front of its middle, as a share of the radius to which it is bent."""
LINE_SAMPLES: Final = 257
SHRINKS: Final = (0.9, 0.8, 0.65)
"""Sizes about the middle of a region's largest circle that are tried if neighbours are lost in all of the region."""
FILL: Final = 0.95
"""Distance of neighbours that is aimed at in a region filled at any cost, as a share of that in the densest pattern."""
ZIGZAG: Final = 0.05
"""A row that goes into a region is a zigzag of this depth first [m], so that it can fold."""
TOUCH_TOLERANCE: Final = 0.02
"""Bodies on ways may overlap by so much [m]."""
SHORTEST_LINE: Final = 0.1
"""Least length of a line that a group is laid along [m]."""


@dataclass(frozen=True, slots=True)
class Transform:
    """What is done with a group's places or ways, in the order of the fields."""

    scale: Point = (1.0, 1.0)
    """Factors in x and z about the middle."""
    size: Point | None = None
    """Or the width and depth [m] to which it is scaled."""
    proportions: Literal["keep", "stretch"] | None = None
    """Of `size`: keep, if left out. Of `along`: stretch fills the line. Of `into`: stretch fills the region at any
    cost, keep uses one factor; left out: the region is filled as far as neighbours stay neighbours."""
    bend_deg: float = 0.0
    """Angle of the arc to which its width is bent; positive: both sides come to the public."""
    rotation_deg: float = 0.0
    """Rotation about its middle; positive turns the front towards +x."""
    centre: Point = (0.0, 0.0)
    """How far it is moved (x, z) [m]."""
    mirror: Line | None = None
    """Line about which it is mirrored."""
    along: tuple[Point, ...] = ()
    """Line on which its width is laid, points (x, z) [m]."""
    into: Rings = ()
    """Region into which it is squeezed."""
    neighbours: Literal["keep", "any"] | None = None
    """Whether neighbours stay neighbours: keep, also where it is stretched; any: places are only mapped, except into a
    region; left out: lines stay lines where it is scaled, and neighbours are kept where it is bent."""

    @property
    def is_exact(self) -> bool:
        """Whether lines stay lines: nothing is bent."""
        return not (self.bend_deg or self.along or self.into)

    @property
    def keeps_neighbours(self) -> bool:
        """Whether neighbours that a map of the floor would part are kept."""
        return self.neighbours == "keep" or (self.neighbours is None and not self.is_exact)

    @property
    def keeps_distances(self) -> bool:
        """Whether all distances stay as they are."""
        return self.is_exact and self.scale == (1.0, 1.0) and self.size is None


@dataclass(frozen=True, slots=True, eq=False)
class Transformed:
    """A transformed group."""

    points: Float64
    """Control points of the ways of D dancers, (C, D, 2) [m]; their places, if there is one."""
    turn: Float64
    """How far the surroundings of each were turned, (D,) [rad]: a heading h becomes turn + h, mirrored turn - h."""
    kept: float
    """Share of the neighbours who still are."""
    least: float
    """Least distance of two dancers [m]; infinite for fewer than two."""


def room_for(transform: Transform) -> Room | None:
    """Return the room into which a transformation leads; None without `into`. PersonError if it has none."""
    return room_of(transform.into) if transform.into else None


def transform_group(
    transform: Transform, points: Float64, basis: Float64 | None = None, coarse: tuple[Float64, Float64] | None = None
) -> Transformed:
    """Return a group's places (1, D, 2), or control points (C, D, 2) of its ways, transformed [m].

    `basis` (S, C) makes the places at S moments from the points of a way; `coarse` (S, N) and (C, N) make displacements
    of places and of points from those of N points. PersonError if the transformation does not
    suit the group: it is bent too far, or more dancers than the region has room for.
    """
    basis = np.eye(len(points)) if basis is None else basis
    source = np.einsum("sc,cdk->sdk", basis, points)
    count = points.shape[1]
    if not count:
        return Transformed(points.copy(), np.zeros(0), 1.0, math.inf)
    room = room_for(transform)
    if room is not None and room.capacity < count:
        people = "1 dancer" if room.capacity == 1 else f"{room.capacity} dancers"
        raise PersonError(f"the region has room for {people}, not for {count}", "a larger region, or fewer dancers")
    moved, turn = map_points(transform, points, source)
    task = Deformation(source, None if coarse is None else coarse[0], mirrored=transform.mirror is not None)
    if room is None:
        first = np.einsum("sc,cdk->sdk", basis, moved)
        near, kept, before = _least(first), task.share_kept(first), _least(source)
        lost = kept < WANTED_SHARE and transform.keeps_neighbours
        if transform.keeps_distances or (near >= min(LEAST_GAP, before) - 1e-9 and not lost):
            return Transformed(moved, turn, kept, near)
        found = task.solve(first, None, min(LEAST_GAP + 0.05, max(before, 2.0 * BODY_RADIUS)))
    else:
        guesses = [_fitted(moved, basis, room, *each) for each in _guesses(transform)]
        first_guesses = [np.einsum("sc,cdk->sdk", basis, each) for each in guesses]
        even = FILL * math.sqrt(room.shape.area / (math.sqrt(0.75) * count))
        gap = max(EASY_GAP, even) if transform.proportions == "stretch" else EASY_GAP
        found = fitted_into(task, first_guesses, room, gap)
        if len(points) == 1:
            turn = turn + _local_turn(moved[0], found)
        moved = guesses[next(k for k, each in enumerate(first_guesses) if each is found.first)]
    shift, least = found.displacement, _least(found.places)
    if coarse is not None:
        if least < min(2.0 * BODY_RADIUS, _least(source)) - TOUCH_TOLERANCE:
            raise PersonError(f"two dancers would come as near as {least:.2f} m", "more room, or fewer dancers")
        shift = np.einsum("cn,ndk->cdk", coarse[1], shift)
    return Transformed(moved + shift, turn, found.kept, least)


def map_points(transform: Transform, points: Float64, source: Float64) -> tuple[Float64, Float64]:
    """Return points (C, D, 2) of the floor of a group with places `source` (S, D, 2) after all but `into` and the
    keeping of neighbours, and how far each of the first D was turned, (D,) [rad]."""
    low, high = source.min(axis=(0, 1)), source.max(axis=(0, 1))
    middle, extent = (low + high) / 2.0, high - low
    factor = _factor(transform, extent)
    now = (points - middle) * factor
    turn = np.zeros(points.shape[1])
    if transform.bend_deg:
        now, bent = _bent(now, math.radians(transform.bend_deg), factor * extent)
        turn = turn + bent[0]
    yaw = math.radians(transform.rotation_deg)
    if yaw:
        now = now @ np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
        turn = turn + yaw
    now = now + middle + np.array(transform.centre)
    if transform.mirror is not None:
        now, turn = mirror_places(now, transform.mirror), 2.0 * transform.mirror.heading - turn
    if transform.along:
        now, laid = _along(now, transform)
        turn = turn + laid[0]
    return now, turn


def _factor(transform: Transform, extent: Float64) -> Float64:
    """Return the factors in x and z."""
    if transform.size is None:
        return np.array(transform.scale)
    wide = extent > 1e-9
    each = np.where(wide, np.array(transform.size) / np.where(wide, extent, 1.0), np.inf)
    if not wide.any():
        return np.ones(2)
    return np.where(wide, each, 1.0) if transform.proportions == "stretch" else np.full(2, float(each.min()))


def _bent(points: Float64, angle: float, extent: Float64) -> tuple[Float64, Float64]:
    """Return points about the middle with the width bent to an arc of `angle` [rad], and the turn of each."""
    if extent[0] < 1e-9:
        return points, np.zeros(points.shape[:-1])
    deepest = 2.0 * DEEPEST_BEND * extent[0] / max(float(extent[1]), 1e-9)
    if abs(angle) > deepest:
        raise PersonError(
            f"bend_deg: a group {extent[0]:.1f} m wide and {extent[1]:.1f} m deep would fold",
            f"bend it by {math.floor(math.degrees(deepest))} degrees at most",
        )
    radius = extent[0] / angle
    at = points[..., 0] / radius
    away = radius - points[..., 1]
    return np.stack([away * np.sin(at), radius - away * np.cos(at)], axis=-1), -at


def _along(points: Float64, transform: Transform) -> tuple[Float64, Float64]:
    """Return points with their width laid on the line, and the turn of each."""
    from scipy.ndimage import gaussian_filter1d

    low, high = points.min(axis=(0, 1)), points.max(axis=(0, 1))
    line = np.array(transform.along)
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    if length[-1] < SHORTEST_LINE:
        raise PersonError(f"along: the line is {length[-1]:.2f} m long", f"draw {SHORTEST_LINE:g} m at least")
    width = float(high[0] - low[0])
    share = 1.0 if width < 1e-9 else length[-1] / width
    at = (points[..., 0] - (low[0] + high[0]) / 2.0) * (
        share if transform.proportions == "stretch" else min(share, 1.0)
    )
    at = at + length[-1] / 2.0
    even = np.linspace(0.0, length[-1], LINE_SAMPLES)
    on_line = np.stack([np.interp(even, length, line[:, axis]) for axis in (0, 1)], axis=1)
    depth = max(float(high[1] - low[1]), 0.1)
    blur = 0.5 * depth / length[-1] * (LINE_SAMPLES - 1)  # a corner is rounded by the depth of the group
    way = gaussian_filter1d(np.gradient(on_line, axis=0), blur, axis=0, mode="nearest")
    yaw = np.unwrap(np.arctan2(-way[:, 1], way[:, 0]))
    turn = np.interp(at, even, yaw)
    aside = points[..., 1] - (low[1] + high[1]) / 2.0
    base = np.stack([np.interp(at, even, on_line[:, axis]) for axis in (0, 1)], axis=-1)
    return base + aside[..., None] * np.stack([np.sin(turn), np.cos(turn)], axis=-1), turn


def _guesses(transform: Transform) -> list[tuple[float, float]]:
    """Return how far a group is stretched to the box of the region (0 to 1), and its size in it, for each guess."""
    if transform.proportions == "stretch":
        return [(1.0, 1.0)]
    if transform.proportions == "keep":
        return [(0.0, 1.0), *((0.0, size) for size in SHRINKS)]
    return [(1.0, 1.0), (0.0, 1.0), *((0.0, size) for size in SHRINKS)]


def _fitted(points: Float64, basis: Float64, room: Room, stretch: float, size: float) -> Float64:
    """Return points scaled to the box of a region, and then to `size` about the middle of its largest circle."""
    source = np.einsum("sc,cdk->sdk", basis, points)
    low, high = source.min(axis=(0, 1)), source.max(axis=(0, 1))
    bounds = np.array(room.shape.bounds)
    wide = (high - low) > 1e-6
    each = np.where(wide, (bounds[2:] - bounds[:2]) / np.where(wide, high - low, 1.0), np.inf)
    least = float(each.min()) if wide.any() else 1.0
    factor = least + stretch * (np.where(wide, each, least) - least)
    now = (points - (low + high) / 2.0) * factor + (bounds[:2] + bounds[2:]) / 2.0
    if not wide.all() and points.shape[1] > 1:
        side = np.where(np.arange(points.shape[1]) % 2 == 0, ZIGZAG, -ZIGZAG)
        now = now + np.where(wide, 0.0, 1.0) * side[None, :, None]
    return np.asarray(room.middle + size * (now - room.middle))


def _local_turn(source: Float64, found: Deformed) -> Float64:
    """Return how far each dancer's neighbours were turned about her, (D,) [rad]."""
    a, b = found.edges.T
    before, after = source[b] - source[a], found.places[0][b] - found.places[0][a]
    across = before[:, 1] * after[:, 0] - before[:, 0] * after[:, 1]
    along = (before * after).sum(axis=1)
    size = len(source)
    sums = [np.bincount(a, each, size) + np.bincount(b, each, size) for each in (across, along)]
    return np.asarray(np.arctan2(sums[0], sums[1]))


def _least(places: Float64) -> float:
    """Return the least distance of two dancers at any moment of places (S, D, 2) [m]."""
    from scipy.spatial import cKDTree

    if places.shape[1] < 2:
        return math.inf
    return min(float(cKDTree(now).query(now, k=2)[0][:, 1].min()) for now in places)


Warp = Callable[[Float64], Float64]


def warp_between(before: Float64, after: Float64) -> Warp:
    """Return a smooth map of the floor that leads places `before` (D, 2) to `after` (D, 2) [m]."""
    from scipy.interpolate import RBFInterpolator
    from scipy.spatial import cKDTree

    kept = np.sort(np.unique(np.round(before, 6), axis=0, return_index=True)[1])
    offset = before[kept] - before[kept].mean(axis=0)
    if len(kept) < 3 or np.linalg.svd(offset, compute_uv=False)[1] < 1e-6:
        return lambda places: after[cKDTree(before).query(places)[1]]
    spline = RBFInterpolator(before[kept], after[kept], smoothing=1e-6)
    return lambda places: np.asarray(spline(places), np.float64)
