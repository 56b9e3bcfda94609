"""Soloists, sections and headings of a formation.

Soloists stand in front of the others or in the middle (T093). Dancers of one section get neighbouring places (T090,
T104). Headings: the public, the middle, outwards, along the line, or an angle (T090, T102).
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely

from live.agents.formations.drawing import Curve, Drawing, curve_of, with_end_gaps
from live.agents.formations.formation_spec import FormationSpec
from live.agents.formations.line_placement import apportion
from live.agents.formations.symmetry import SymmetryLine
from live.base.arrays import Float64, Int64


def soloist_places(
    spec: FormationSpec, drawing: Drawing, others: Float64, number: int, line: SymmetryLine | None
) -> Float64:
    """Return the places of `number` soloists, shape (number, 2): side by side before all `others` (S, 2), or around
    the middle.

    With a symmetry line they stand at its end, or around the middle of its part in the shape: the one without a partner
    exactly on it, the others in pairs beside it.
    """
    gap = spec.soloist_gap
    if spec.soloist_place == "centre":
        return _ring_places(drawing, number, gap, line)
    aside = gap * (np.arange(number) - (number - 1) / 2)[:, None]
    middle, ahead = _axis(drawing, line)
    front = float(((others - middle) @ ahead).max()) if len(others) else -gap
    return np.asarray(middle + (front + gap) * ahead + aside * np.array([ahead[1], -ahead[0]]))


def _axis(drawing: Drawing, line: SymmetryLine | None) -> tuple[Float64, Float64]:
    """Return the middle of the soloists (2,) [m] and the direction to their front (2,): along a symmetry line."""
    middle = np.array(drawing.middle)
    return (middle, np.array([0.0, 1.0])) if line is None else (line.project(middle[None])[0], line.direction)


def _ring_places(drawing: Drawing, number: int, gap: float, line: SymmetryLine | None) -> Float64:
    middle, ahead = _axis(drawing, line)
    if number == 1:
        return middle[None]
    angle = 2.0 * math.pi * np.arange(number)[:, None] / number
    aside = np.array([ahead[1], -ahead[0]])
    radius = gap / (2.0 * math.sin(math.pi / number))
    return np.asarray(middle + radius * (np.cos(angle) * ahead + np.sin(angle) * aside))


def clear_soloist_area(spec: FormationSpec, drawing: Drawing, line: SymmetryLine | None) -> Drawing:
    """Return the drawing without the parts closer to central soloists than their gap.

    PersonError if nothing is left for the others.
    """
    if spec.soloists == 0 or spec.soloist_place != "centre":
        return drawing
    soloists = _ring_places(drawing, spec.soloists, spec.soloist_gap, line)
    taken: Any = shapely.MultiPoint(soloists).buffer(spec.soloist_gap)
    curves = []
    for curve in drawing.curves:
        drawn = shapely.LineString(curve.points)
        if not drawn.intersects(taken):
            curves.append(curve)
            continue
        parts = [part for part in shapely.get_parts(drawn.difference(taken)) if part.length > 1e-9]
        merged = shapely.get_parts(shapely.line_merge(shapely.MultiLineString(parts))) if parts else []
        left = [curve_of(shapely.get_coordinates(part), closed=False) for part in merged]
        curves += [each for each in left if each is not None]
    region = None if drawing.region is None else drawing.region.difference(taken)
    if (region is None and not curves) or (region is not None and region.area < 0.1 * drawing.region.area):
        spec.refuse(
            "soloist_gap", "the soloists in the middle leave no room for the others", "a smaller gap or a larger size"
        )
    if region is not None:
        shapely.prepare(region)
    return Drawing(with_end_gaps(curves), region, drawing.middle)


def section_sizes(wanted: tuple[int, ...], count: int) -> list[int]:
    """Return section sizes with the sum `count`: as `wanted`, or in the same proportions."""
    if sum(wanted) == count:
        return list(wanted)
    sizes = np.array(wanted, np.float64)
    return [int(each) for each in apportion(count, sizes, np.zeros(len(sizes)), np.zeros(len(sizes), np.int64))]


def sections_along(sizes: list[int]) -> Int64:
    """Return the section (from 0) of each place, in the order along the lines, shape (sum of sizes,)."""
    return np.repeat(np.arange(len(sizes), dtype=np.int64), sizes)


def sections_in_area(places: Float64, sizes: list[int]) -> Int64:
    """Return the section (from 0) of each of the places (S, 2) by repeatedly halving the area across its longer side.

    Sections are ordered from left to right, then from front to back.
    """
    section = np.zeros(len(places), np.int64)
    _halve(places, np.arange(len(places)), sizes, 0, section)
    return section


def _halve(places: Float64, members: Int64, sizes: list[int], first: int, section: Int64) -> None:
    if len(sizes) == 1:
        section[members] = first
        return
    cut = min(range(1, len(sizes)), key=lambda n: abs(2 * sum(sizes[:n]) - sum(sizes)))
    x, z = np.round(places[members], 9).T
    wide = len(members) > 0 and np.ptp(x) >= np.ptp(z)
    ordered = members[np.lexsort((-z, x) if wide else (x, -z))]
    taken = sum(sizes[:cut])
    _halve(places, ordered[:taken], sizes[:cut], first, section)
    _halve(places, ordered[taken:], sizes[cut:], first + cut, section)


def place_headings(
    spec: FormationSpec, places: Float64, ways: Float64 | None, middle: Float64, curves: Sequence[Curve]
) -> Float64:
    """Return the heading of each of the places (S, 2) [rad], in [-π, π), shape (S,).

    `ways` (S, 2) are unit vectors along the lines, None for dancers inside: they face along the nearest line. A dancer
    at the exact middle faces the public.
    """
    if spec.heading == "public" or not len(places):
        return np.zeros(len(places))
    if spec.heading == "angle":
        return np.full(len(places), _wrap_angle(np.array(math.radians(spec.heading_deg))))
    if spec.heading == "along":
        way = _nearest_tangents(places, curves) if ways is None else ways
    else:
        way = middle - places if spec.heading == "centre" else places - middle
        way = np.where((np.hypot(way[:, 0], way[:, 1]) < 1e-6)[:, None], np.array([0.0, 1.0]), way)
    return _wrap_angle(np.arctan2(way[:, 0], way[:, 1]))


def _wrap_angle(angle: Float64) -> Float64:
    return np.asarray(np.mod(angle + math.pi, 2.0 * math.pi) - math.pi)


def _nearest_tangents(places: Float64, curves: Sequence[Curve]) -> Float64:
    """Return unit vectors along the line nearest to each of the places, shape (S, 2)."""
    points = shapely.points(places)
    drawn = np.array([shapely.LineString(curve.points) for curve in curves])
    nearest = np.argmin([shapely.distance(line, points) for line in drawn], axis=0)
    ways = np.zeros_like(places)
    for n, curve in enumerate(curves):
        own = nearest == n
        at = shapely.line_locate_point(drawn[n], points[own])
        ways[own] = curve.tangent(np.asarray(at, np.float64))
    return ways
