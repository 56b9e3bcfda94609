"""Room for bodies in a region of the floor: how far inside a place is, and how many fit (T145)."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final, cast

import numpy as np
import shapely

from live.base.arrays import Float64
from live.base.errors import PersonError

BODY_RADIUS: Final = 0.25
"""Radius of a body [m]; its middle stays so far inside the edge of a region."""
LEAST_GAP: Final = 2.0 * BODY_RADIUS + 0.1
"""Least distance of two dancers of a transformed group [m]: bodies do not touch."""
CELLS: Final = 160
"""Cells of the field of distances along the longer side of a region."""
SMALLEST_CELL: Final = 0.025
"""Least distance of these cells [m]."""
ANGLES: Final = (0.0, 15.0, 30.0, 45.0)
SHIFTS: Final = 4
"""Directions and positions (along each axis) of the lattices that are tried to find out how many fit."""
LARGE: Final = 3000
"""Where more fit, one lattice is tried."""
MAX_CORNERS: Final = 2000
Rings = tuple[tuple[tuple[float, float], ...], ...]
"""Closed lines that enclose a region, points (x, z) [m]; a line within another one encloses a hole."""


@dataclass(frozen=True, slots=True, eq=False)
class Room:
    """The part of a region where the middles of bodies may be."""

    shape: Any
    """A shapely polygon or several."""
    origin: Float64
    """First place of the field of distances (x, z) [m]."""
    cell: float
    """Distance of its places [m]."""
    field: Float64
    """Distance from the edge at each place [m], positive inside, (X, Z)."""
    lattice: Float64
    """The most places found that are `LEAST_GAP` apart, (N, 2) [m]."""

    middle: Float64
    """Middle of the largest circle inside, (2,) [m]."""

    @property
    def capacity(self) -> int:
        """How many dancers surely fit."""
        return len(self.lattice)

    def depth(self, places: Float64) -> tuple[Float64, Float64]:
        """Return how far inside the edge `places` (K, 2) are [m], negative outside, (K,), and the gradient, (K, 2)."""
        at = np.clip((places - self.origin) / self.cell, 0.0, np.array(self.field.shape) - 1.001)
        low = at.astype(np.int64)
        u, v = (at - low).T
        x, z = low.T
        a, b = self.field[x, z], self.field[x + 1, z]
        c, d = self.field[x, z + 1], self.field[x + 1, z + 1]
        value = (a * (1 - u) + b * u) * (1 - v) + (c * (1 - u) + d * u) * v
        slope = np.stack([(b - a) * (1 - v) + (d - c) * v, (c - a) * (1 - u) + (d - b) * u], axis=1) / self.cell
        return value, slope

    def contains(self, places: Float64, tolerance: float = 1e-9) -> Any:
        """Whether each of `places` (K, 2) is inside or on the edge, (K,)."""
        return shapely.distance(self.shape, shapely.points(places)) <= tolerance

    def nearest(self, places: Float64) -> Float64:
        """Return `places` (K, 2), those outside moved to the nearest place inside."""
        outside = np.flatnonzero(~self.contains(places, 0.0))
        if not len(outside):
            return places
        moved = places.copy()
        lines = shapely.shortest_line(self.shape, shapely.points(places[outside]))
        moved[outside] = shapely.get_coordinates(lines)[::2]
        return moved


def region_of(rings: Rings) -> Any:
    """Return the region that closed lines enclose, by the even-odd rule. PersonError if that is not clear."""
    region = None
    if sum(map(len, rings)) > MAX_CORNERS:
        raise PersonError(f"more than {MAX_CORNERS} points", "draw it with fewer points")
    for ring in rings:
        if len(set(ring)) < 3:
            raise PersonError("a closed line needs three different points at least", "[[-3, 0], [3, 0], [0, 4]]")
        polygon = shapely.Polygon(ring)
        if not polygon.is_valid:
            raise PersonError(
                f"the line crosses or touches itself ({shapely.is_valid_reason(polygon)[:60]}): what is inside is not "
                "clear",
                "draw it without crossings, or as several closed lines",
            )
        region = polygon if region is None else region.symmetric_difference(polygon)
    if region is None:
        raise PersonError("the points of a region expected", "[[-3, 0], [3, 0], [0, 4]]")
    return region


@lru_cache(maxsize=32)
def room_of(rings: Rings) -> Room:
    """Return the room of a region. PersonError if the region is invalid or has no room for a body."""
    shape = cast(Any, region_of(rings)).buffer(-BODY_RADIUS)
    if shape.is_empty:
        raise PersonError("has room for nobody", f"make it wider than {2.0 * BODY_RADIUS:g} m")
    shapely.prepare(shape)
    low_x, low_z, high_x, high_z = shape.bounds
    longer = max(high_x - low_x, high_z - low_z, 0.1)
    cell, beyond = max(longer / CELLS, SMALLEST_CELL), max(2.0, 0.3 * longer)
    x = np.arange(low_x - beyond, high_x + beyond + cell, cell)
    z = np.arange(low_z - beyond, high_z + beyond + cell, cell)
    points = shapely.points(*np.meshgrid(x, z, indexing="ij"))
    edge = shapely.boundary(shape)
    shapely.prepare(edge)
    distance = shapely.distance(edge, points)
    field = np.where(shapely.contains(shape, points), distance, -distance)
    deepest = np.unravel_index(int(np.argmax(field)), field.shape)
    middle = np.array([x[deepest[0]], z[deepest[1]]])
    return Room(shape, np.array([x[0], z[0]]), cell, field, _lattice(shape), middle)


def _box_lattice(bounds: Float64, staggered: float) -> Float64:
    """Return rows of places that reach the edges of a box, (N, 2), each row shifted by a share of the distance."""
    width, depth = bounds[2:] - bounds[:2]
    rows = int(depth / (LEAST_GAP * (math.sqrt(0.75) if staggered else 1.0)) + 1e-9) + 1
    columns = int(width / LEAST_GAP + 1e-9) + 1
    step = width / max(columns - 1, 1) if not staggered else LEAST_GAP
    z = np.linspace(bounds[1], bounds[3], rows) if rows > 1 else np.array([(bounds[1] + bounds[3]) / 2.0])
    x = bounds[0] + step * np.arange(columns) if columns > 1 else np.array([(bounds[0] + bounds[2]) / 2.0])
    return np.concatenate(
        [np.stack([x + staggered * step * (row % 2), np.full(columns, at)], 1) for row, at in enumerate(z)]
    )


def _lattice(shape: Any) -> Float64:
    """Return the largest of some lattices inside a shape, (N, 2), at least one place."""
    low_x, low_z, high_x, high_z = shape.bounds
    middle = np.array([low_x + high_x, low_z + high_z]) / 2.0
    reach = int(math.hypot(high_x - low_x, high_z - low_z) / LEAST_GAP / 1.7) + 2
    rows, columns = np.meshgrid(np.arange(-reach, reach + 1), np.arange(-reach, reach + 1), indexing="ij")
    flat = np.stack([columns + 0.5 * (rows % 2), rows * math.sqrt(0.75)], axis=-1).reshape(-1, 2) * LEAST_GAP
    best = shapely.get_coordinates(shapely.point_on_surface(shape))
    for staggered in (0.0, 0.5):
        places = _box_lattice(np.array(shape.bounds), staggered)
        inside = shapely.distance(shape, shapely.points(places)) <= 1e-9
        if inside.sum() > len(best):
            best = places[inside]
    large = shape.area > LARGE * LEAST_GAP**2
    for angle in map(math.radians, ANGLES[:1] if large else ANGLES):
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        for shift in np.ndindex((1, 1) if large else (SHIFTS, SHIFTS)):
            move = np.array(shift) / SHIFTS * LEAST_GAP * np.array([1.0, math.sqrt(3.0)])
            places = (flat + move) @ turn + middle
            inside = shapely.contains_xy(shape, places[:, 0], places[:, 1])
            if inside.sum() > len(best):
                best = places[inside]
    return np.ascontiguousarray(best)
