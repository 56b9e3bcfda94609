"""Outlines of the shapes around their own middle, in shape units (T090, Fig 4.4), and the staggered rows of "grid"."""

import math
from collections.abc import Callable
from typing import Final

import numpy as np

from live.agents.formations.formation_spec import FormationSpec
from live.agents.formations.stroke_font import STROKES, text_strokes
from live.agents.formations.svg_import import path_lines
from live.base.arrays import Float64

Line = tuple[Float64, bool]
"""Points (P, 2), +z to the public, and whether the line is closed."""

CIRCLE_POINTS: Final = 180
"""Points per circle: the arc length is exact to 1e-4."""


def shape_lines(spec: FormationSpec) -> list[Line]:
    """Return the lines of a shape in its own units; closed ones begin nearest to the public. PersonError if there are
    none.
    """
    return _SHAPES[spec.shape](spec)


def _line(_spec: FormationSpec) -> list[Line]:
    return [(np.array([[-0.5, 0.0], [0.5, 0.0]]), False)]


def _arc_points(begin: float, end: float, points: int) -> Float64:
    """Return points on the unit circle between two headings."""
    heading = np.linspace(begin, end, points + 1)
    return np.stack([np.sin(heading), np.cos(heading)], axis=1)


def _circle(_spec: FormationSpec) -> list[Line]:
    points = _arc_points(0.0, 2.0 * math.pi, CIRCLE_POINTS)
    points[-1] = points[0]
    return [(points, True)]


def _arc(spec: FormationSpec) -> list[Line]:
    half = math.radians(spec.arc_deg) / 2
    return [(_arc_points(math.pi + half, math.pi - half, CIRCLE_POINTS), False)]


def _rectangle(_spec: FormationSpec) -> list[Line]:
    return [(np.array([[-0.5, 0.5], [0.5, 0.5], [0.5, -0.5], [-0.5, -0.5], [-0.5, 0.5]]), True)]


def _polygon(spec: FormationSpec) -> list[Line]:
    if spec.points:
        return [(np.array(spec.points[0], np.float64), True)]
    return [(_arc_points(math.pi, 3.0 * math.pi, spec.corners), True)]


def _star(spec: FormationSpec) -> list[Line]:
    points = _arc_points(math.pi, 3.0 * math.pi, 2 * spec.corners)
    points[1::2] *= spec.inner
    return [(points, True)]


def _spiral(spec: FormationSpec) -> list[Line]:
    """Return Archimedes' spiral from the middle outwards, with equal distance between turns."""
    turn = np.linspace(0.0, spec.turns, round(CIRCLE_POINTS * spec.turns) + 1)
    heading = 2.0 * math.pi * turn
    radius = turn / spec.turns
    return [(np.stack([np.sin(heading) * radius, np.cos(heading) * radius], axis=1), False)]


def _text(spec: FormationSpec) -> list[Line]:
    try:
        return list(text_strokes(spec.text.strip()))
    except KeyError as error:
        spec.refuse(
            "text", f"the letter {str(error.args[0])[:4]!r} is not in the font", f"there are: {' '.join(STROKES)}"
        )


def _path(spec: FormationSpec) -> list[Line]:
    where = f"formation {spec.name!r}: path" if spec.name else "formation: path"
    lines = [line for d in spec.path for line in path_lines(d, where)]
    return [(line, _is_closed(line, spec)) for line in lines]


def _polyline(spec: FormationSpec) -> list[Line]:
    lines = [np.array(points, np.float64) for points in spec.points]
    return [(line, _is_closed(line, spec)) for line in lines]


def _is_closed(line: Float64, spec: FormationSpec) -> bool:
    if spec.closed is not None:
        return spec.closed
    length = np.hypot(*np.diff(line, axis=0).T).sum()
    return bool(spec.inside or np.hypot(*(line[0] - line[-1])) <= 1e-6 * length)


_SHAPES: Final[dict[str, Callable[[FormationSpec], list[Line]]]] = {
    "grid": _rectangle,
    "line": _line,
    "arc": _arc,
    "circle": _circle,
    "ellipse": _circle,
    "polygon": _polygon,
    "rectangle": _rectangle,
    "star": _star,
    "spiral": _spiral,
    "text": _text,
    "path": _path,
    "polyline": _polyline,
    "places": _polyline,
}


def staggered_rows(count: int, size: tuple[float, float]) -> Float64:
    """Return `count` places around (0, 0), front row first, in a rectangle `size` [m], shape (count, 2)."""
    if count == 0:
        return np.zeros((0, 2))
    rows = min(max(1, round(math.sqrt(count * size[1] / max(size[0], 1e-6)))), count)
    per_row = [count // rows + (1 if row < count % rows else 0) for row in range(rows)]
    places: list[tuple[float, float]] = []
    widest = max(per_row)
    gap = size[0] / widest
    for row, members in enumerate(per_row):
        z = 0.0 if rows == 1 else (0.5 - row / (rows - 1)) * size[1]
        shift = 0.0 if members != widest or row % 2 == 0 else 0.5 * gap
        for member in range(members):
            places.append(((member - (members - 1) / 2) * gap + shift * 0.5 * (1 if row % 4 == 1 else -1), z))
    return np.array(places)
