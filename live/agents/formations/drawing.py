"""A shape on the stage: its lines in metres, and the region that closed ones enclose (T090).

A line on the floor, measured along its way, on which dancers can be placed (T090).
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Final

import numpy as np
import numpy.typing as npt
import shapely

from live.agents.formations.formation_spec import FARTHEST, FormationSpec
from live.agents.formations.shapes import Line, shape_lines

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


DEFAULT_SIZE: Final = (8.0, 5.0)
SMALLEST_AREA: Final = 0.01
"""A region is not smaller [m²]."""
SMALLEST_LENGTH: Final = 0.05
"""All lines together are not shorter [m]."""
MOST_LINES: Final = 500
_STRETCHED: Final = ("line", "grid", "rectangle", "ellipse")


@dataclass(frozen=True, slots=True, eq=False)
class Drawing:
    """What is drawn on the floor."""

    curves: tuple[Curve, ...]
    region: Any
    """What closed lines enclose (a shapely polygon or several), None where dancers are on lines."""
    middle: tuple[float, float]
    """Middle of the shape (x, z) [m]."""

    @property
    def length(self) -> float:
        """Metres of all lines."""
        return sum(curve.length for curve in self.curves)


@lru_cache(maxsize=64)
def drawing_of(spec: FormationSpec) -> Drawing:
    """The lines and the region of a spec, on the stage. PersonError, naming the field, where they cannot be used."""
    lines = _placed(spec, shape_lines(spec))
    joined = _joined(lines) if spec.shape in ("path", "polyline") else lines
    curves = [curve for points, closed in joined if (curve := curve_of(points, closed=closed)) is not None]
    if sum(curve.length for curve in curves) < SMALLEST_LENGTH:
        spec.refuse(_field(spec), f"all lines together are shorter than {SMALLEST_LENGTH:g} m: no room for dancers")
    if len(curves) > MOST_LINES:
        spec.refuse(_field(spec), f"{len(curves)} lines; {MOST_LINES} at most")
    corners = np.concatenate([curve.points for curve in curves])
    if np.abs(corners).max() > FARTHEST:
        spec.refuse(_field(spec), f"reaches {np.abs(corners).max():.4g} m from the middle of the stage; give a size")
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle = (float(low[0] + high[0]) / 2, float(low[1] + high[1]) / 2)
    if spec.shape not in ("path", "polyline") and not (spec.shape == "polygon" and spec.points):
        middle = spec.centre
    region = _region(spec, lines) if spec.inside or spec.shape == "grid" else None
    return Drawing(met(curves), region, middle)


def _field(spec: FormationSpec) -> str:
    """The field that a person has to change if the shape is no good."""
    return {"path": "path", "polyline": "points", "text": "text"}.get(spec.shape, "points" if spec.points else "size")


def _placed(spec: FormationSpec, lines: list[Line]) -> list[Line]:
    """Fit the lines into the size, turn them and bring them to the centre; drawn metres stay as they are."""
    everything = np.concatenate([points for points, _ in lines])
    low, high = everything.min(axis=0), everything.max(axis=0)
    if spec.points and spec.size is None:
        factor, middle, origin = np.ones(2), (low + high) / 2, (low + high) / 2 + spec.centre
    else:
        factor, middle, origin = _factor(spec, high - low), (low + high) / 2, np.array(spec.centre)
    yaw = math.radians(spec.rotation_deg)
    cos, sin = math.cos(yaw), math.sin(yaw)
    turn = np.array([[cos, -sin], [sin, cos]])  # rows: (0, 1) comes to (sin, cos)
    return [(((points - middle) * factor) @ turn + origin, closed) for points, closed in lines]


def _factor(spec: FormationSpec, extent: Float64) -> Float64:
    """Metres per unit in x and z."""
    size = np.array(spec.size or DEFAULT_SIZE)
    if spec.size is not None and spec.shape == "line":
        size = np.array([size[0], 1.0])
    wide = extent > 1e-12 * max(float(extent.max()), 1e-300)
    if not wide.any():
        spec.refuse(_field(spec), "all points are the same: there is no line")
    each = np.where(wide, size / np.where(wide, extent, 1.0), np.inf)
    stretch = spec.proportions == "stretch" or (
        spec.proportions is None and (spec.shape in _STRETCHED or (spec.shape == "circle" and spec.size is not None))
    )
    return np.where(np.isinf(each), 1.0, each) if stretch else np.full(2, each.min())


def _joined(lines: list[Line]) -> list[Line]:
    """Open lines that meet end to end as one line; what begins where another ends is one stroke."""
    opened = [
        shapely.LineString(points) for points, closed in lines if not closed and len(np.unique(points, axis=0)) > 1
    ]
    if len(opened) < 2:
        return lines
    merged = shapely.line_merge(shapely.MultiLineString(opened))
    parts = [shapely.get_coordinates(part) for part in shapely.get_parts(merged)]
    ends = [(part, bool(np.hypot(*(part[0] - part[-1])) < 1e-9)) for part in parts]
    return [line for line in lines if line[1]] + ends


def met(curves: list[Curve]) -> tuple[Curve, ...]:
    """The lines with gaps at the ends that lie on other lines, so that two dancers never share a joint."""
    if len(curves) < 2:
        return tuple(curves)
    drawn = np.array([shapely.LineString(curve.points) for curve in curves])
    taken: list[Float64] = []
    found: list[Curve] = []
    for n, curve in enumerate(curves):
        gaps = [FREE, FREE]
        for side, end in enumerate((curve.points[0], curve.points[-1])):
            if curve.closed:
                break
            others = np.delete(np.arange(len(curves)), n)
            near = others[shapely.distance(drawn[others], shapely.Point(end)) < 1e-3]
            if not len(near):
                continue
            if any(_passes(curves[other], end) for other in near):
                gaps[side] = MEETS
            elif any(np.hypot(*(place - end)) < 1e-3 for place in taken):
                gaps[side] = SHARED
            else:
                taken.append(end)  # the first line that ends here has the dancer
        found.append(replace(curve, gaps=(gaps[0], gaps[1])))
    return tuple(found)


def _passes(curve: Curve, point: Float64) -> bool:
    """Whether the line goes on on both sides of the point."""
    if curve.closed:
        return True
    return bool(np.hypot(*(curve.points[0] - point)) > 1e-3 and np.hypot(*(curve.points[-1] - point)) > 1e-3)


def _region(spec: FormationSpec, lines: list[Line]) -> Any:
    """What the closed lines enclose; one within another is a hole (even-odd)."""
    closed = [points for points, is_closed in lines if is_closed]
    if not closed or len(closed) < len(lines):
        spec.refuse("dancers", f"inside needs closed lines, and {spec.shape!r} has an open one", "dancers = 'on'")
    region = None
    for points in closed:
        if len(np.unique(points, axis=0)) < 3:
            spec.refuse(_field(spec), "a closed line needs three different points at least")
        polygon = shapely.Polygon(points)
        if not polygon.is_valid:
            why = shapely.is_valid_reason(polygon)
            spec.refuse(
                _field(spec),
                f"the line crosses or touches itself ({why[:60]}): what is inside is not clear",
                "draw it as several closed lines, or put dancers on it",
            )
        region = polygon if region is None else region.symmetric_difference(polygon)
    if region is None or region.area < SMALLEST_AREA:
        spec.refuse(_field(spec), f"encloses less than {SMALLEST_AREA:g} m²: no room for dancers", "give a larger size")
    shapely.prepare(region)
    return region
