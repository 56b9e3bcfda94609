"""Symmetry about a line: one side is kept and reflected (T092, Fig 4.6)."""

import math
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
import shapely

from live.agents.formations.drawing import FREE_END, JOINT, SYMMETRY_END, Curve, Drawing, curve_of, with_end_gaps
from live.agents.formations.formation_spec import MAX_DISTANCE, FormationSpec
from live.base.arrays import Float64

LINE_TOLERANCE: Final = 1e-6
"""Largest distance of a point on the symmetry line [m]."""
_SIDES: Final = {"left": (-1.0, 0.0), "right": (1.0, 0.0), "front": (0.0, 1.0), "back": (0.0, -1.0)}
_DIRECTIONS: Final = {"left-right": 0.0, "front-back": 90.0}
"""Directions of the lines with a name [degrees]."""
_CORNER_SINE: Final = math.sin(math.radians(14.0))
"""Sine of the angle above which a line forms a corner with its reflection at the symmetry line."""


@dataclass(frozen=True, slots=True, eq=False)
class SymmetryLine:
    """A line through `point` with the unit `normal` pointing to the kept side."""

    point: Float64
    normal: Float64

    @property
    def direction(self) -> Float64:
        """Unit vector along the line, pointing towards the public; from left to right if that is no direction of it."""
        way = np.array([-self.normal[1], self.normal[0]])
        return -way if (way[1] if abs(way[1]) > 1e-12 else way[0]) < 0.0 else way

    def signed_distance(self, points: Float64) -> Float64:
        """Return the signed distance from the line [m], shape (K,), positive on the kept side."""
        return np.asarray((points - self.point) @ self.normal)

    def reflect(self, points: Float64) -> Float64:
        """Return the points (K, 2) reflected."""
        return np.asarray(points - 2.0 * self.signed_distance(points)[:, None] * self.normal)

    def project(self, points: Float64) -> Float64:
        """Return the nearest points of the line to the points (K, 2)."""
        return np.asarray(points - self.signed_distance(points)[:, None] * self.normal)

    def reflect_directions(self, ways: Float64) -> Float64:
        """Return the directions (K, 2) reflected."""
        return np.asarray(ways - 2.0 * (ways @ self.normal)[:, None] * self.normal)

    def reflect_shape(self, shape: Any) -> Any:
        """Return a shapely geometry reflected."""
        return shapely.transform(shape, self.reflect)

    def kept_half(self) -> Any:
        """Return the kept half-plane, as a polygon that exceeds every stage."""
        far = 8.0 * MAX_DISTANCE
        a, b = self.point + self.direction * far, self.point - self.direction * far
        return shapely.Polygon([a, b, b + self.normal * far, a + self.normal * far])


def symmetry_line(spec: FormationSpec, drawing: Drawing) -> SymmetryLine | None:
    """Return the symmetry line of a spec, through the middle of the stage unless the spec names another line.

    The kept side is the left one, else that at the back; if nothing of the drawing lies there, the other one.
    PersonError if the side that the spec keeps does not fit the line.
    """
    if spec.mirror is None:
        return None
    if isinstance(spec.mirror, tuple):
        point, way = np.array(spec.mirror[0], np.float64), np.subtract(spec.mirror[1], spec.mirror[0])
        way = way / np.hypot(*way)
    else:
        angle = math.radians(_DIRECTIONS[spec.mirror] if isinstance(spec.mirror, str) else spec.mirror)
        way = np.round([math.sin(angle), math.cos(angle)], 15)  # a quarter turn leads exactly from side to side
        point = np.array(spec.mirror_at or (0.0, 0.0), np.float64)
    normal = np.array([way[1], -way[0]])
    keep = spec.mirror_keep or ("left" if abs(normal[0]) > 1e-9 else "back")
    towards = float(normal @ np.array(_SIDES[keep]))
    if abs(towards) < 1e-9:
        other = "front or back" if keep in ("left", "right") else "left or right"
        spec.refuse("mirror_keep", f"the symmetry line has no {keep} side", f"keep {other}")
    line = SymmetryLine(point, normal if towards > 0 else -normal)
    reach = max((float(line.signed_distance(curve.points).max()) for curve in drawing.curves), default=0.0)
    if spec.mirror_keep is None and reach < LINE_TOLERANCE:
        return SymmetryLine(point, -line.normal)
    return line


def clip_drawing(spec: FormationSpec, drawing: Drawing, line: SymmetryLine) -> tuple[list[Curve], list[Curve], Any]:
    """Return the lines on the kept side, those on the symmetry line itself, and the kept half of the region.

    Ends on the symmetry line have the gap HALF. PersonError if nothing lies on the kept side.
    """
    half = line.kept_half()
    region = None if drawing.region is None else drawing.region.intersection(half)
    kept: list[Curve] = []
    on_line: list[Curve] = []
    for curve in drawing.curves:
        for points, closed in _clip_to_half(curve, line, half):
            part = curve_of(points, closed=closed)
            if part is not None and not curve.use_corners:
                part = replace(part, corners=(), use_corners=False)
            if part is not None:
                (on_line if np.abs(line.signed_distance(part.points)).max() < LINE_TOLERANCE else kept).append(part)
    if not (kept or on_line) or (region is not None and region.area < 1e-6):
        spec.refuse("mirror", "nothing lies on the side that is kept", "keep the other side (mirror_keep)")
    on_axis = [shapely.LineString(curve.points) for curve in on_line]
    return [_with_symmetry_gaps(curve, line, on_axis) for curve in with_end_gaps(kept)], on_line, region


def _clip_to_half(curve: Curve, line: SymmetryLine, half: Any) -> list[tuple[Float64, bool]]:
    side = line.signed_distance(curve.points)
    if side.min() >= LINE_TOLERANCE or np.abs(side).max() < LINE_TOLERANCE:
        return [(curve.points, curve.closed)]
    if side.max() < -LINE_TOLERANCE:
        return []
    cut = shapely.LineString(curve.points).intersection(half)
    parts = [part for part in shapely.get_parts(cut) if part.geom_type == "LineString"]
    if not parts:
        return []
    merged = shapely.line_merge(shapely.MultiLineString(parts)) if len(parts) > 1 else parts[0]
    return [(shapely.get_coordinates(part), False) for part in shapely.get_parts(merged)]


def _with_symmetry_gaps(curve: Curve, line: SymmetryLine, on_axis: list[Any]) -> Curve:
    if curve.closed:
        return curve
    gaps = list(curve.gaps)
    for n, end in enumerate((curve.points[0], curve.points[-1])):
        if abs(float(line.signed_distance(end[None])[0])) < LINE_TOLERANCE:
            touches = any(shapely.distance(each, shapely.Point(end)) < 1e-3 for each in on_axis)
            gaps[n] = JOINT if touches else SYMMETRY_END
    return replace(curve, gaps=(gaps[0], gaps[1]))


def places_on_line(curves: list[Curve], line: SymmetryLine, count: int, *, corners: bool) -> Float64:
    """Return places on the symmetry line itself, such that an even number of dancers remains, shape (K, 2).

    One for an odd `count`, at a corner if there is one and else nearest to the public; with `corners` as many corners
    as parity allows.
    """
    ends: list[tuple[bool, float, Float64]] = []
    for curve in curves:
        for n in (0, -1):
            if curve.closed or curve.gaps[n] != SYMMETRY_END:
                continue
            end = curve.points[n]
            way = curve.points[1 if n == 0 else -2] - end
            slanted = curve.use_corners and abs(float(way @ line.direction)) > _CORNER_SINE * float(np.hypot(*way))
            if not any(np.hypot(*(end - other)) < 1e-3 for _, _, other in ends):
                ends.append((slanted, float(end @ line.direction), end))
    middle = np.mean([end for _, _, end in ends], axis=0) @ line.direction if ends else 0.0
    ends.sort(key=lambda each: (not each[0], -abs(each[1] - middle) if each[0] else 0.0, -each[1]))
    wanted = count % 2
    if corners:
        slanted_ends = sum(1 for each in ends if each[0])
        wanted = max(wanted, slanted_ends - (slanted_ends - count) % 2)
    wanted = min(wanted, len(ends), count)
    wanted -= (count - wanted) % 2 if wanted > 0 else 0
    return np.array([end for _, _, end in ends[: max(wanted, 0)]]).reshape(-1, 2)


def with_shared_ends(curve: Curve, places: Float64, shared: float) -> Curve:
    """Return the line with the gap `shared` at ends that coincide with one of `places` (K, 2)."""
    if curve.closed or not len(places):
        return curve
    gaps = [
        shared if gap != FREE_END and np.hypot(*(places - end).T).min() < 1e-3 else gap
        for gap, end in zip(curve.gaps, (curve.points[0], curve.points[-1]), strict=True)
    ]
    return replace(curve, gaps=(gaps[0], gaps[1]))
