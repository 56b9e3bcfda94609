"""A formation's shape on the stage: lines in metres, measured along their length, and the enclosed region (T090)."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Final

import numpy as np
import numpy.typing as npt
import shapely

from live.agents.formations.formation_spec import MAX_DISTANCE, FormationSpec
from live.agents.formations.shapes import Line, shape_lines
from live.base.arrays import Float64

CORNER_ANGLE: Final = math.radians(28.0)
"""A turn above this angle at a point is a corner."""

FREE_END: Final = 0.0
"""Gap, in spacings, between the end of a line and its first dancer: the dancer stands on the end."""
SYMMETRY_END: Final = 0.5
"""The end lies on a symmetry line: the reflected dancer is one spacing away."""
JOINT: Final = 0.75
"""The end lies on another line, whose dancers use the place."""
SHARED_END: Final = 1.0
"""The end is already occupied by a dancer."""


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A line of P points; `at` is the position along it, in metres, or in mass for weighted spacing."""

    points: Float64
    """Shape (P, 2) [m]; a closed line repeats its first point at the end."""
    at: Float64
    """Shape (P,), ascending from 0."""
    closed: bool
    corners: tuple[float, ...] = ()
    """Positions of the corners in units of `at`; ends of open lines are not corners."""
    gaps: tuple[float, float] = (FREE_END, FREE_END)
    """FREE_END, SYMMETRY_END, JOINT or SHARED_END, for both ends of an open line."""
    use_corners: bool = True
    """Whether its corners may be filled first."""

    @property
    def length(self) -> float:
        """Total length in units of `at`."""
        return float(self.at[-1])

    def points_at(self, at: Float64) -> Float64:
        """Return the points at `at` (K,), shape (K, 2); a closed line wraps around."""
        at = np.mod(at, self.length) if self.closed and self.length > 0 else at
        return np.stack([np.interp(at, self.at, self.points[:, 0]), np.interp(at, self.at, self.points[:, 1])], axis=1)

    def tangent(self, at: Float64) -> Float64:
        """Return unit vectors along the line at `at` (K,), shape (K, 2); on a corner, of the outgoing side."""
        at = np.mod(at, self.length) if self.closed and self.length > 0 else at
        piece = np.clip(np.searchsorted(self.at, at, side="right") - 1, 0, len(self.at) - 2)
        way = self.points[piece + 1] - self.points[piece]
        return np.asarray(way / np.maximum(np.hypot(way[:, 0], way[:, 1]), 1e-12)[:, None])


def curve_of(points: Float64, *, closed: bool) -> Curve | None:
    """Return the curve through `points` (P, 2) with its corners, or None if it has no length."""
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
    """Return the indices of points with a sharp turn, without the ends of an open line."""
    way = np.diff(points, axis=0)
    heading = np.arctan2(way[:, 1], way[:, 0])
    if closed:
        heading = np.concatenate([heading[-1:], heading])
    turn = np.abs(np.mod(np.diff(heading) + math.pi, 2.0 * math.pi) - math.pi)
    return np.flatnonzero(turn > CORNER_ANGLE) + (0 if closed else 1)


def restart_at(curve: Curve, at: float) -> Curve:
    """Return the same closed line with its start at `at` [m along it]."""
    at = math.fmod(at, curve.length)
    if at < 1e-9 or curve.length - at < 1e-9:
        return curve
    ahead = curve.at > at + 1e-9
    start = curve.points_at(np.array([at]))
    turned = np.concatenate([start, curve.points[ahead], curve.points[1:][~ahead[1:]], start])
    again = curve_of(turned, closed=True)
    return curve if again is None else again


DEFAULT_SIZE: Final = (8.0, 5.0)
MIN_AREA: Final = 0.01
"""Smallest area of a region [m²]."""
MIN_LENGTH: Final = 0.05
"""Smallest total length of all lines [m]."""
MAX_LINES: Final = 500
_STRETCHED_SHAPES: Final = ("line", "grid", "rectangle", "ellipse")


@dataclass(frozen=True, slots=True, eq=False)
class Drawing:
    """The lines and region of a shape on the floor."""

    curves: tuple[Curve, ...]
    region: Any
    """Region enclosed by closed lines (a shapely polygon or several), None if dancers stand on lines."""
    middle: tuple[float, float]
    """Middle of the shape (x, z) [m]."""

    @property
    def length(self) -> float:
        """Total length of all lines [m]."""
        return sum(curve.length for curve in self.curves)


@lru_cache(maxsize=64)
def drawing_of(spec: FormationSpec) -> Drawing:
    """Return the lines and the region of a spec, on the stage. PersonError, naming the field, if they are unusable."""
    lines = _placed(spec, shape_lines(spec))
    joined = _merge_lines(lines) if spec.shape in ("path", "polyline") else lines
    curves = [curve for points, closed in joined if (curve := curve_of(points, closed=closed)) is not None]
    if sum(curve.length for curve in curves) < MIN_LENGTH:
        spec.refuse(_invalid_field(spec), f"all lines together are shorter than {MIN_LENGTH:g} m: no room for dancers")
    if len(curves) > MAX_LINES:
        spec.refuse(_invalid_field(spec), f"{len(curves)} lines; {MAX_LINES} at most")
    corners = np.concatenate([curve.points for curve in curves])
    if np.abs(corners).max() > MAX_DISTANCE:
        spec.refuse(
            _invalid_field(spec), f"reaches {np.abs(corners).max():.4g} m from the middle of the stage; give a size"
        )
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle = (float(low[0] + high[0]) / 2, float(low[1] + high[1]) / 2)
    if spec.shape not in ("path", "polyline") and not (spec.shape == "polygon" and spec.points):
        middle = spec.centre
    region = _region(spec, lines) if spec.inside or spec.shape == "grid" else None
    return Drawing(with_end_gaps(curves), region, middle)


def places_by_hand(spec: FormationSpec) -> Float64:
    """Return the written places of shape "places", (S, 2) [m]: as drawn lines they are fitted into a size, rotated
    about their middle and moved by the centre. PersonError if they leave the floor."""
    places = _placed(spec, [(np.array(spec.points[0], np.float64), False)])[0][0]
    if np.abs(places).max() > MAX_DISTANCE:
        spec.refuse("points", f"reach {np.abs(places).max():.4g} m from the middle of the stage; give a size")
    return places


def _invalid_field(spec: FormationSpec) -> str:
    """Return the field to change if the shape is unusable."""
    return {"path": "path", "polyline": "points", "text": "text"}.get(spec.shape, "points" if spec.points else "size")


def _placed(spec: FormationSpec, lines: list[Line]) -> list[Line]:
    """Fit the lines into the size, rotate them and move them to the centre; lines drawn in metres keep their size."""
    everything = np.concatenate([points for points, _ in lines])
    low, high = everything.min(axis=0), everything.max(axis=0)
    if spec.points and spec.size is None:
        factor, middle, origin = np.ones(2), (low + high) / 2, (low + high) / 2 + spec.centre
    else:
        factor, middle, origin = _scale_factor(spec, high - low), (low + high) / 2, np.array(spec.centre)
    yaw = math.radians(spec.rotation_deg)
    cos, sin = math.cos(yaw), math.sin(yaw)
    turn = np.array([[cos, -sin], [sin, cos]])  # rows: maps (0, 1) to (sin, cos)
    return [(((points - middle) * factor) @ turn + origin, closed) for points, closed in lines]


def _scale_factor(spec: FormationSpec, extent: Float64) -> Float64:
    """Return the scale in x and z [m per unit]."""
    size = np.array(spec.size or DEFAULT_SIZE)
    if spec.size is not None and spec.shape == "line":
        size = np.array([size[0], 1.0])
    wide = extent > 1e-12 * max(float(extent.max()), 1e-300)
    if not wide.any():
        spec.refuse(_invalid_field(spec), "all points are the same: there is no line")
    each = np.where(wide, size / np.where(wide, extent, 1.0), np.inf)
    stretch = spec.proportions == "stretch" or (
        spec.proportions is None
        and (spec.shape in _STRETCHED_SHAPES or (spec.shape == "circle" and spec.size is not None))
    )
    return np.where(np.isinf(each), 1.0, each) if stretch else np.full(2, each.min())


def _merge_lines(lines: list[Line]) -> list[Line]:
    """Merge open lines that meet end to end."""
    opened = [
        shapely.LineString(points) for points, closed in lines if not closed and len(np.unique(points, axis=0)) > 1
    ]
    if len(opened) < 2:
        return lines
    merged = shapely.line_merge(shapely.MultiLineString(opened))
    parts = [shapely.get_coordinates(part) for part in shapely.get_parts(merged)]
    ends = [(part, bool(np.hypot(*(part[0] - part[-1])) < 1e-9)) for part in parts]
    return [line for line in lines if line[1]] + ends


def with_end_gaps(curves: list[Curve]) -> tuple[Curve, ...]:
    """Return the lines with gaps at ends on other lines, so that two dancers never share a joint."""
    if len(curves) < 2:
        return tuple(curves)
    drawn = np.array([shapely.LineString(curve.points) for curve in curves])
    taken: list[Float64] = []
    found: list[Curve] = []
    for n, curve in enumerate(curves):
        gaps = [FREE_END, FREE_END]
        for side, end in enumerate((curve.points[0], curve.points[-1])):
            if curve.closed:
                break
            others = np.delete(np.arange(len(curves)), n)
            near = others[shapely.distance(drawn[others], shapely.Point(end)) < 1e-3]
            if not len(near):
                continue
            if any(_passes_through(curves[other], end) for other in near):
                gaps[side] = JOINT
            elif any(np.hypot(*(place - end)) < 1e-3 for place in taken):
                gaps[side] = SHARED_END
            else:
                taken.append(end)  # the first line that ends here gets the dancer
        found.append(replace(curve, gaps=(gaps[0], gaps[1])))
    return tuple(found)


def _passes_through(curve: Curve, point: Float64) -> bool:
    """Whether the point is inside the line, not at its end."""
    if curve.closed:
        return True
    return bool(np.hypot(*(curve.points[0] - point)) > 1e-3 and np.hypot(*(curve.points[-1] - point)) > 1e-3)


def _region(spec: FormationSpec, lines: list[Line]) -> Any:
    """Return the region enclosed by the closed lines; nested lines are holes (even-odd)."""
    closed = [points for points, is_closed in lines if is_closed]
    if not closed or len(closed) < len(lines):
        spec.refuse("dancers", f"inside needs closed lines, and {spec.shape!r} has an open one", "dancers = 'on'")
    region = None
    for points in closed:
        if len(np.unique(points, axis=0)) < 3:
            spec.refuse(_invalid_field(spec), "a closed line needs three different points at least")
        polygon = shapely.Polygon(points)
        if not polygon.is_valid:
            why = shapely.is_valid_reason(polygon)
            spec.refuse(
                _invalid_field(spec),
                f"the line crosses or touches itself ({why[:60]}): what is inside is not clear",
                "draw it as several closed lines, or put dancers on it",
            )
        region = polygon if region is None else region.symmetric_difference(polygon)
    if region is None or region.area < MIN_AREA:
        spec.refuse(
            _invalid_field(spec), f"encloses less than {MIN_AREA:g} m²: no room for dancers", "give a larger size"
        )
    shapely.prepare(region)
    return region
