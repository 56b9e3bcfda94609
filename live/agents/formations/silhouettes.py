"""Concentric silhouettes: the outline of a region again and again, each ring further in (T091, T093, Fig 4.5 c)."""

import math
from typing import Any, Final

import numpy as np
import numpy.typing as npt
import shapely

from live.agents.formations.curve import Curve, begin_at, curve_of

Float64 = npt.NDArray[np.float64]

MITRE: Final = 3.0
EVEN_ENOUGH: Final = 0.7
_TINY: Final = 0.3
"""A ring smaller than this share of the ring distance is a place in the middle."""


def silhouettes(region: Any, count: int, radius: float, middle: Float64) -> tuple[list[Curve], Float64]:
    """Rings for `count` dancers, outermost first, so far apart as neighbours on them; and a place in the middle.

    `radius` and `middle` (2,) are those of the largest circle inside (`widest_circle`). The rings are closed lines
    that begin in front; the place has the shape (1, 2), or (0, 2) where there is none. By Steiner's formula n dancers
    at distance d need rings of A / d + L / 2 metres; the innermost ring lies half a ring distance from the middle, or
    is the middle itself, whichever comes nearer to that.
    """
    area, outline = float(region.area), float(region.length)
    wished = (outline / 2 + math.sqrt(outline**2 / 4 + 4.0 * count * area)) / (2.0 * count)
    rings = max(0, round(radius / wished - 0.5))
    options = [(radius / (n + 0.5), n + 1, False) for n in range(max(0, rings - 1), rings + 2)]
    whole = max(1, round(radius / wished))
    if _is_round(region, radius, radius / whole):
        options.append((radius / whole, whole, True))
    best, chosen, centre = math.inf, [region], False
    for distance, number, has_centre in options:
        inner = [_inner(region, n * distance) for n in range(number)]
        dancers = max(count - has_centre, 1)
        mismatch = abs(math.log(sum(float(each.length) for each in inner) / dancers / distance))
        if mismatch < best:
            best, chosen, centre = mismatch, inner, has_centre
    return [curve for each in chosen for curve in _rings(each)], middle[None] if centre else np.zeros((0, 2))


def widest_circle(region: Any) -> tuple[float, Float64]:
    """Radius [m] and middle (2,) of the largest circle inside a region; takes milliseconds."""
    found = shapely.maximum_inscribed_circle(region, tolerance=0.005 * math.sqrt(region.area))
    return float(found.length), np.asarray(shapely.get_coordinates(found)[0])


def _is_round(region: Any, radius: float, distance: float) -> bool:
    """Whether the innermost ring shrinks to a single place."""
    core = region.buffer(-(radius - _TINY * distance))
    if core.is_empty or core.geom_type != "Polygon":
        return False
    low_x, low_z, high_x, high_z = core.bounds
    return bool(max(high_x - low_x, high_z - low_z) < 1.5 * distance)


def _inner(region: Any, inwards: float) -> Any:
    return region if inwards == 0.0 else region.buffer(-inwards, join_style="mitre", mitre_limit=MITRE)


def _rings(inner: Any) -> list[Curve]:
    curves = []
    for part in shapely.get_parts(inner):
        for ring in (part.exterior, *part.interiors):
            curve = curve_of(shapely.get_coordinates(ring), closed=True)
            if curve is not None:
                curves.append(_begun_in_front(curve))
    return curves


def _begun_in_front(curve: Curve) -> Curve:
    """The ring, begun where it is nearest to the public, in the middle of it if that is a whole side."""
    low, high = curve.points.min(axis=0), curve.points.max(axis=0)
    front = shapely.Point((low[0] + high[0]) / 2, high[1] + 10.0 * (high[1] - low[1] + 1.0))
    return begin_at(curve, float(shapely.LineString(curve.points).project(front)))


def unmarked(curves: list[Curve], count: int) -> list[Curve]:
    """The rings without corners where standing on all corners would make gaps uneven; the outermost keeps its own."""
    lengths = sum(curve.length for curve in curves)
    plain = []
    for n, curve in enumerate(curves):
        sides = np.diff([*curve.corners, curve.corners[0] + curve.length]) if curve.corners else np.zeros(0)
        spacing = lengths / max(count, 1)
        gaps = sides / np.maximum(np.round(sides / spacing), 1.0)
        even = n == 0 or not len(gaps) or gaps.min() > EVEN_ENOUGH * gaps.max()
        plain.append(curve if even else Curve(curve.points, curve.at, True, marked=False))
    return plain
