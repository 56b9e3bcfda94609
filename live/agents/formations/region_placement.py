"""Placement inside a region by pattern, with and without symmetry (T091, T092, T144).

Concentric silhouettes repeat the outline of a region, each ring further in (T091, T093, Fig 4.5 c).
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

import numpy as np
import shapely

from live.agents.formations.blue_noise import Density, hexagonal_spacing, midpoint_on_line, scatter, scatter_mirrored
from live.agents.formations.drawing import Curve, Drawing, curve_of, restart_at
from live.agents.formations.formation_spec import FormationSpec
from live.agents.formations.lattice import place_on_lattice
from live.agents.formations.line_placement import density_at, place_mirrored, place_on_curves
from live.agents.formations.symmetry import SymmetryLine, clip_drawing
from live.base.arrays import Float64

MITRE_LIMIT: Final = 3.0
TABLE_SIZE: Final = 24
MIN_GAP_RATIO: Final = 0.7
_TINY: Final = 0.3
"""A ring smaller than this share of the ring distance becomes a place in the middle."""


@dataclass(frozen=True, slots=True, eq=False)
class RingCore:
    """Precomputed data of a region for its rings; takes milliseconds to compute."""

    region: Any
    coarse: Any
    """The region simplified (error at most 2 mm), for fast rings."""
    radius: float
    middle: Float64
    """Radius [m] and middle (2,) of the largest inscribed circle."""
    inward_offsets: Float64
    lengths: Float64
    """Ring length [m] at each inward offset [m], both (K,)."""


def ring_core(region: Any) -> RingCore:
    """Return the core of a region."""
    coarse = region.simplify(0.002)
    found = shapely.maximum_inscribed_circle(coarse, tolerance=0.005 * math.sqrt(region.area))
    inwards = np.linspace(0.0, float(found.length), TABLE_SIZE)
    lengths = np.array([float(_inset_region(coarse, float(each)).length) for each in inwards])
    return RingCore(region, coarse, float(found.length), shapely.get_coordinates(found)[0], inwards, lengths)


def concentric_rings(core: RingCore, count: int) -> tuple[list[Curve], Float64]:
    """Return rings for `count` dancers, outermost first, spaced like neighbours on them, and a place in the middle.

    The rings are closed lines that begin in front; the place has the shape (1, 2), or (0, 2) if there is none. By
    Steiner's formula n dancers at distance d need rings of A / d + L / 2 metres. The innermost ring lies half a ring
    distance from the middle, or is the middle itself, whichever makes distances along and across most similar.
    """
    area, outline = float(core.region.area), float(core.region.length)
    wished = (outline / 2 + math.sqrt(outline**2 / 4 + 4.0 * count * area)) / (2.0 * count)
    rings = max(0, round(core.radius / wished - 0.5))
    options = [(core.radius / (n + 0.5), n + 1, False) for n in range(max(0, rings - 2), rings + 3)]
    whole = max(1, round(core.radius / wished))
    if _is_round(core, core.radius / whole):
        options.append((core.radius / whole, whole, True))

    def mismatch(option: tuple[float, int, bool]) -> float:
        distance, number, centre = option
        length = float(np.interp(distance * np.arange(number), core.inward_offsets, core.lengths).sum())
        return abs(math.log(max(length, 1e-9) / max(count - centre, 1) / distance))

    distance, number, centre = min(options, key=mismatch)
    return list(_all_rings(core, distance, number)), core.middle[None] if centre else np.zeros((0, 2))


@lru_cache(maxsize=256)
def _all_rings(core: RingCore, distance: float, number: int) -> tuple[Curve, ...]:
    """Return the rings of a core; cached, since few distances occur, each for many counts."""
    inner = [core.region if n == 0 else _inset_region(core.coarse, n * distance) for n in range(number)]
    return tuple(curve for each in inner for curve in _rings(each))


def _is_round(core: RingCore, distance: float) -> bool:
    """Whether the innermost ring shrinks to a single place."""
    inmost = core.coarse.buffer(-(core.radius - _TINY * distance))
    if inmost.is_empty or inmost.geom_type != "Polygon":
        return False
    low_x, low_z, high_x, high_z = inmost.bounds
    return bool(max(high_x - low_x, high_z - low_z) < 1.5 * distance)


def _inset_region(region: Any, inwards: float) -> Any:
    return region if inwards == 0.0 else region.buffer(-inwards, join_style="mitre", mitre_limit=MITRE_LIMIT)


def _rings(inner: Any) -> list[Curve]:
    curves = []
    for part in shapely.get_parts(inner):
        for ring in (part.exterior, *part.interiors):
            curve = curve_of(shapely.get_coordinates(ring), closed=True)
            if curve is not None:
                curves.append(_start_in_front(curve))
    return curves


def _start_in_front(curve: Curve) -> Curve:
    """Return the ring with its start nearest to the public, in the middle of a front side."""
    low, high = curve.points.min(axis=0), curve.points.max(axis=0)
    front = shapely.Point((low[0] + high[0]) / 2, high[1] + 10.0 * (high[1] - low[1] + 1.0))
    return restart_at(curve, float(shapely.LineString(curve.points).project(front)))


def without_uneven_corners(curves: list[Curve], count: int) -> list[Curve]:
    """Return the rings, without corners where filling all corners would make gaps uneven; the outermost keeps its
    corners.
    """
    lengths = sum(curve.length for curve in curves)
    plain = []
    for n, curve in enumerate(curves):
        sides = np.diff([*curve.corners, curve.corners[0] + curve.length]) if curve.corners else np.zeros(0)
        spacing = lengths / max(count, 1)
        gaps = sides / np.maximum(np.round(sides / spacing), 1.0)
        even = n == 0 or not len(gaps) or gaps.min() > MIN_GAP_RATIO * gaps.max()
        plain.append(curve if even else Curve(curve.points, curve.at, True, use_corners=False))
    return plain


HALF_OVERLAP: Final = 2e-7


@dataclass(frozen=True, slots=True, eq=False)
class PlacementRegion:
    """A region and its precomputed data."""

    region: Any
    half: Any
    """Its kept half, None without a symmetry line."""
    line: SymmetryLine | None
    core: RingCore | None
    """For concentric silhouettes only."""


def placement_region(spec: FormationSpec, drawing: Drawing, line: SymmetryLine | None) -> PlacementRegion:
    """Return the region of a drawing with closed lines, symmetrical if the spec has a mirror."""
    region, half = drawing.region, None
    if line is not None:
        half = clip_drawing(spec, drawing, line)[2]
        overlapping = half.buffer(HALF_OVERLAP, join_style="mitre")  # avoids a slit between the halves from rounding
        region = overlapping.union(line.reflect_shape(overlapping))
        shapely.prepare(region)
    return PlacementRegion(region, half, line, ring_core(region) if spec.distribution == "concentric" else None)


def place_inside(spec: FormationSpec, ground: PlacementRegion, count: int, seed: int) -> Float64:
    """Return `count` places inside a region, shape (count, 2)."""
    if count == 0:
        return np.zeros((0, 2))
    region, half, line = ground.region, ground.half, ground.line
    if count == 1:
        return (_region_middle(region) if half is None or line is None else midpoint_on_line(half, line))[None]
    pattern = spec.distribution
    if pattern in ("grid", "diagonal"):
        found = _place_on_lattice(spec, region, count, line)
        if found is not None:
            return found
    if ground.core is not None:
        return _place_on_rings(spec, ground.core, line, count)
    density: Density | None = (lambda points: density_at(spec, points)) if pattern == "weighted" else None
    even = pattern in ("even", "grid", "diagonal")
    if half is not None and line is not None:
        return scatter_mirrored(half, line, count, seed, density=density, even=even)
    return scatter(region, count, seed, density=density, even=even)


def count_by_spacing(spec: FormationSpec, region: Any, spacing: float) -> int:
    """Return the approximate number of dancers inside with neighbours `spacing` [m] apart."""
    area = float(region.area)
    if spec.distribution == "concentric":
        return round(area / spacing**2 + float(region.length) / (2.0 * spacing))
    # achieved share of the hexagonal spacing
    reached = {"poisson": 0.7, "weighted": 0.6, "even": 0.85}.get(spec.distribution)
    if reached is None:
        return round(area / spacing**2)
    return round((reached * hexagonal_spacing(area, 1) / spacing) ** 2)


def _region_middle(region: Any) -> Float64:
    """Return the centre of the bounding box if it is inside, else of the largest inscribed circle, shape (2,)."""
    low_x, low_z, high_x, high_z = region.bounds
    centre = np.array([(low_x + high_x) / 2, (low_z + high_z) / 2])
    if shapely.contains_xy(region, centre[0], centre[1]):
        return centre
    return np.asarray(shapely.get_coordinates(shapely.maximum_inscribed_circle(region))[0])


def _place_on_lattice(spec: FormationSpec, region: Any, count: int, line: SymmetryLine | None) -> Float64 | None:
    diagonal = spec.distribution == "diagonal"
    if line is None:
        yaw = math.radians(spec.rotation_deg)
        turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
        turned = shapely.get_coordinates(region) @ turn.T
        origin = ((turned.min(axis=0) + turned.max(axis=0)) / 2) @ turn
        return place_on_lattice(region, count, origin, yaw, diagonal=diagonal)
    low_x, low_z, high_x, high_z = region.bounds
    centre = np.array([(low_x + high_x) / 2, (low_z + high_z) / 2])
    origin = line.project(centre[None])[0]
    yaw = math.atan2(line.direction[0], line.direction[1])
    found = place_on_lattice(region, count, origin, yaw, diagonal=diagonal, symmetrical=True)
    if found is None:
        return None
    kept = found[line.signed_distance(found) > 1e-4]
    on_line = line.project(found[np.abs(line.signed_distance(found)) <= 1e-4])
    if 2 * len(kept) + len(on_line) != count:  # a reflection near the border fell outside
        return None
    return np.concatenate([kept, on_line, line.reflect(kept)])


def _place_on_rings(spec: FormationSpec, core: RingCore, line: SymmetryLine | None, count: int) -> Float64:
    curves, middle = concentric_rings(core, count)
    curves = without_uneven_corners(curves, count)
    corners = spec.mark_corners is not False
    if line is None:
        return np.concatenate([place_on_curves(curves, count - len(middle), corners=corners)[0], middle])
    on_line = line.project(middle)
    rings = Drawing(tuple(curves), None, (0.0, 0.0))
    kept, straight, _ = clip_drawing(spec, rings, line)
    places = place_mirrored(kept, straight, line, count - len(middle), corners=corners)[0]
    return np.concatenate([places, on_line])
