"""Placement on the lines of a drawing with exact counts: even or weighted, optionally corners first and symmetrical,
with no two dancers on one joint (T091).
"""

from dataclasses import replace
from typing import Final

import numpy as np

from live.agents.formations.distances import close_pairs
from live.agents.formations.drawing import SHARED_END, Curve, Drawing
from live.agents.formations.formation_spec import FormationSpec
from live.agents.formations.symmetry import SymmetryLine, clip_drawing, places_on_line, with_shared_ends
from live.base.arrays import Float64, Int64


def apportion(count: int, lengths: Float64, fixed: Float64, lower_bounds: Int64) -> Int64:
    """Split `count` over C lines so that their gaps are as equal as possible (Webster's method), shape (C,).

    Line c of `lengths[c]` with k dancers has k + `fixed[c]` gaps; each gets at least `least[c]`, whose sum is at most
    `count`. Ties go to the outermost lines of the list, so that symmetrical shapes stay symmetrical.
    """
    given = lower_bounds.astype(np.int64).copy()
    if count - int(given.sum()) > 16:  # most at once, the rest one by one
        gap = float(lengths.sum()) / max(count + float(fixed.sum()), 1.0)
        ahead = np.maximum(given, np.floor(lengths / max(gap, 1e-12) - fixed).astype(np.int64) - 1)
        given = ahead if ahead.sum() <= count else given
    number = np.arange(len(lengths))
    rank = np.minimum(number, len(lengths) - 1 - number) + 1e-3 * number
    for _ in range(count - int(given.sum())):
        priority = lengths / np.maximum(given + fixed + 0.5, 0.5)
        best = np.flatnonzero(priority >= priority.max() * (1.0 - 1e-9))
        given[best[np.argmin(rank[best])]] += 1
    return given


def apportion_over_curves(count: int, curves: "list[Curve]") -> Int64:
    """Return the number of dancers on each line, shape (C,), with the sum `count`."""
    lengths = np.array([curve.length for curve in curves])
    fixed = np.array([0.0 if curve.closed else sum(curve.gaps) - 1.0 for curve in curves])
    return apportion(count, lengths, fixed, np.zeros(len(curves), np.int64))


def positions_along(curve: Curve, count: int, *, corners: bool, phase: float = 0.0) -> Float64:
    """Return positions of `count` dancers along a line, in units of its `at`, shape (count,), ascending.

    With `corners` each corner gets a dancer, if there are enough, and sides are filled as evenly as whole numbers
    allow. `phase` shifts dancers on a closed line without marked corners, in spacings.
    """
    if count == 0:
        return np.zeros(0)
    if curve.closed:
        marked = np.array(curve.corners) if corners else np.zeros(0)
        if not 0 < len(marked) <= count:
            return np.asarray((np.arange(count) + phase) * (curve.length / count), np.float64)
        ends = np.append(marked, marked[0] + curve.length)
        return np.asarray(np.sort(np.mod(_place_on_sides(ends, count, (0.0, 0.0))[:count], curve.length)))
    inner = np.array(curve.corners) if corners else np.zeros(0)
    ends = np.concatenate([[0.0], inner, [curve.length]])
    least = _min_gaps(len(ends) - 1, curve.gaps)
    if least.sum() > count - 1:
        ends = np.array([0.0, curve.length])
    if count - 1 + sum(curve.gaps) <= 0:
        return np.array([curve.length / 2])
    return _place_on_sides(ends, count - 1, curve.gaps)


def _min_gaps(sides: int, gaps: tuple[float, float]) -> Int64:
    """Return the smallest number of whole gaps of each side: one between two corners."""
    least = np.ones(sides, np.int64)
    least[0] -= gaps[0] > 0
    least[-1] -= gaps[1] > 0
    return np.maximum(least, 0)


def _place_on_sides(ends: Float64, whole: int, gaps: tuple[float, float]) -> Float64:
    """Place dancers on all `ends` (except gaps at the first and last) and evenly between; `whole` gaps in total."""
    lengths = np.diff(ends)
    parts = np.zeros(len(lengths))
    parts[0] += gaps[0]
    parts[-1] += gaps[1]
    number = apportion(
        whole, lengths, parts, _min_gaps(len(lengths), gaps) if len(lengths) > 1 else np.zeros(1, np.int64)
    )
    found = []
    for n, length in enumerate(lengths):
        gap = length / max(number[n] + parts[n], 1e-9)
        begin = ends[n] + (gaps[0] * gap if n == 0 else 0.0)
        found.append(begin + gap * np.arange(number[n] + (n == len(lengths) - 1)))
    return np.concatenate(found)


PlacesAndTangents = tuple[Float64, Float64]
"""Places (S, 2) [m] and unit vectors along the line (S, 2)."""

NO_PLACES: Final = np.zeros((0, 2))
CROWDED_SHARE: Final = 0.6
"""Dancers of different lines closer than this share of the spacing are moved apart along their lines."""
MAX_SHIFTS: Final = 2
"""Largest number of dancers moved from a crowded line to the least crowded one."""
WEIGHTED_SAMPLES: Final = 500
"""Number of samples of a weighted line."""
_CORNER_SHAPES: Final = ("text", "polygon", "rectangle", "star")


def place_on_lines(spec: FormationSpec, drawing: Drawing, count: int, line: SymmetryLine | None) -> PlacesAndTangents:
    """Return `count` places on the lines of a drawing, in the order of the lines."""
    corners = spec.shape in _CORNER_SHAPES if spec.mark_corners is None else spec.mark_corners
    if line is None:
        return place_on_curves([_weighted_curve(spec, curve) for curve in drawing.curves], count, corners=corners)
    kept, on_line, _ = clip_drawing(spec, drawing, line)
    return place_mirrored(
        [_weighted_curve(spec, curve) for curve in kept],
        [_weighted_curve(spec, curve) for curve in on_line],
        line,
        count,
        corners=corners,
    )


def place_on_curves(
    curves: list[Curve], count: int, *, corners: bool, line: SymmetryLine | None = None, taken: Float64 = NO_PLACES
) -> PlacesAndTangents:
    """Return `count` places over all lines, with gaps as equal as possible.

    They keep away from `taken` places (K, 2) and, with a symmetry `line`, from all reflections.
    """
    if not curves:
        return NO_PLACES, NO_PLACES
    number = apportion_over_curves(count, curves)
    at, places = _placed(curves, number, corners, line, taken)
    for _ in range(MAX_SHIFTS if len(curves) > 1 else 0):  # a small ring may fit fewer than its share by length
        crowded = _crowded_lines(places, curves, line, taken)
        if not crowded:
            break
        lengths = np.array([curve.length for curve in curves])
        moved = number.copy()
        moved[crowded[0]] -= 1
        moved[np.argmax(np.where(np.arange(len(curves)) == crowded[0], 0.0, lengths / np.maximum(number, 0.5)))] += 1
        other_at, other_places = _placed(curves, moved, corners, line, taken)
        if _min_distance(other_places, line, taken) <= _min_distance(places, line, taken) * (1.0 + 1e-6):
            break
        number, at, places = moved, other_at, other_places
    ways = [curve.tangent(each) for curve, each in zip(curves, at, strict=True)]
    return np.concatenate(places), np.concatenate(ways)


def _placed(
    curves: list[Curve], number: Int64, corners: bool, line: SymmetryLine | None, taken: Float64
) -> tuple[list[Float64], list[Float64]]:
    """Return positions and places of `number` (C,) dancers on each line, shifted where lines come close."""
    at = [positions_along(curve, int(k), corners=corners) for curve, k in zip(curves, number, strict=True)]
    places = [curve.points_at(each) for curve, each in zip(curves, at, strict=True)]
    for n in _crowded_lines(places, curves, line, taken):
        others = np.concatenate([*places[:n], *places[n + 1 :], NO_PLACES])
        others = np.concatenate([others, taken, _reflections(others, line)])
        options = [at[n], *_alternative_positions(curves[n], int(number[n]), corners)]
        apart = [_min_distance_from(curves[n].points_at(each), others, line) for each in options]
        at[n] = options[int(np.argmax(np.round(apart, 6)))]
        places[n] = curves[n].points_at(at[n])
    return at, places


def place_mirrored(
    kept: list[Curve], on_line: list[Curve], line: SymmetryLine, count: int, *, corners: bool
) -> PlacesAndTangents:
    """Return `count` places, symmetrical about `line`, on the kept halves of lines, their reflections, and lines on it.

    If the count is odd and no line meets the symmetry line, one more place lies on it, in the middle.
    """
    whole = 2.0 * sum(curve.length for curve in kept)
    straight = sum(curve.length for curve in on_line)
    single = round(count * straight / (whole + straight))
    single += (count - single) % 2 if kept and on_line else 0
    if on_line:
        middle_places, middle_ways = place_on_curves(on_line, min(single, count), corners=corners)
    else:
        middle_places = places_on_line(kept, line, count, corners=corners)
        if (count - len(middle_places)) % 2:
            centre = np.mean([curve.points.mean(axis=0) for curve in kept], axis=0)
            middle_places = line.project(centre[None])
        middle_ways = np.tile(line.direction, (len(middle_places), 1))
    pairs = (count - len(middle_places)) // 2
    halves = [with_shared_ends(curve, middle_places, SHARED_END) for curve in kept]
    places, ways = place_on_curves(halves, pairs, corners=corners, line=line, taken=middle_places)
    return (
        np.concatenate([places, middle_places, line.reflect(places)[::-1]]),
        np.concatenate([ways, middle_ways, line.reflect_directions(ways)[::-1]]),
    )


def _reflections(places: Float64, line: SymmetryLine | None) -> Float64:
    return NO_PLACES if line is None else line.reflect(places)


def _crowded_lines(places: list[Float64], curves: list[Curve], line: SymmetryLine | None, taken: Float64) -> list[int]:
    """Return the indices of lines with dancers too close to others, descending."""
    own = np.concatenate(places)
    everybody = np.concatenate([taken, own, _reflections(own, line)])
    if len(own) == 0 or len(everybody) < 2:
        return []
    owner = np.repeat(np.arange(len(curves)), [len(each) for each in places])
    owner = np.concatenate([np.full(len(taken), -1), owner, owner])
    spacing = sum(curve.length for curve in curves) / len(own)
    near = close_pairs(everybody, CROWDED_SHARE * spacing)
    return sorted({int(owner[pair[1]]) for pair in near} - {-1}, reverse=True)


def _alternative_positions(curve: Curve, count: int, corners: bool) -> list[Float64]:
    """Return alternative positions on the same line: a closed one shifted, an open one inset at its ends."""
    if count == 0:
        return []
    if curve.closed:
        return [positions_along(curve, count, corners=False, phase=phase / 6) for phase in range(6)]
    drawn_in = [replace(curve, gaps=(a, b)) for a in (curve.gaps[0], 0.5) for b in (curve.gaps[1], 0.5)]
    return [positions_along(each, count, corners=marked) for each in drawn_in for marked in {corners, False}]


def _min_distance(places: list[Float64], line: SymmetryLine | None, taken: Float64) -> float:
    """Return the smallest distance of two places [m]."""
    return _min_distance_from(np.concatenate(places), taken, line)


def _min_distance_from(places: Float64, others: Float64, line: SymmetryLine | None) -> float:
    """Return the smallest distance [m] between `places` (S, 2), or from them to reflections or `others` (T, 2)."""
    everybody = np.concatenate([places, others, _reflections(places, line)])
    squared = (places[:, 0, None] - everybody[None, :, 0]) ** 2 + (places[:, 1, None] - everybody[None, :, 1]) ** 2
    np.fill_diagonal(squared, np.inf)
    return float(np.sqrt(squared.min(initial=np.inf)))


def _weighted_curve(spec: FormationSpec, curve: Curve) -> Curve:
    """Return the line measured in mass instead of metres, if dancers are denser in parts of it."""
    if spec.distribution != "weighted":
        return curve
    at = np.union1d(curve.at, np.linspace(0.0, curve.length, WEIGHTED_SAMPLES))
    points = curve.points_at(np.minimum(at, curve.length * (1.0 - 1e-12)))
    if not curve.closed:
        points[-1] = curve.points[-1]
    density = density_at(spec, points)
    if spec.weights:
        weights = np.array([*spec.weights, spec.weights[0]] if curve.closed else spec.weights, np.float64)
        density = density * np.interp(at / curve.length, np.linspace(0.0, 1.0, len(weights)), weights)
    density = np.maximum(density, 1e-6 * density.max())
    mass = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(at))])
    mass *= curve.length / mass[-1]
    corners = tuple(float(each) for each in np.interp(curve.corners, at, mass)) if curve.corners else ()
    return replace(curve, points=points, at=mass, corners=corners)


def density_at(spec: FormationSpec, points: Float64) -> Float64:
    """Return the density at `points` (K, 2) due to the focus: 1 far from it, 1 + strength in it, shape (K,)."""
    if spec.focus is None:
        return np.ones(len(points))
    squared = ((points - np.array(spec.focus)) ** 2).sum(axis=1)
    return np.asarray(1.0 + spec.focus_strength * np.exp(-np.minimum(squared / (2.0 * spec.focus_reach**2), 700.0)))
