"""SVG drawing of a formation from above, audience below (Fig 4.4 to 4.6)."""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from live.agents.formations.formation import Formation
from live.agents.formations.symmetry import SymmetryLine
from live.app.pictures import svg
from live.base.arrays import Float64

PIXELS: Final = 60.0
"""Pixels per metre, for stages not wider than `WIDEST`."""
WIDEST: Final = 900.0
TOP: Final = 52.0
SIDE: Final = 46.0
BOTTOM: Final = 58.0
BODY: Final = 0.25
"""Radius of a dancer [m]."""
INK, FAINT, FLOOR, DRAWN, WAY, AXIS = "#222222", "#dcdcdc", "#f7f6f2", "#b9b3a4", "#8aa5c4", "#c03030"
SECTIONS: Final = ("#3d6fa5", "#5b9a68", "#c98a2e", "#8a5aa8", "#3b9aa0", "#b8577a", "#7d7d3a", "#6a6a6a")
SOLOIST: Final = "#d0342c"


class _FloorScale:
    """Conversion of stage metres to pixels: x to the right, audience below."""

    def __init__(self, stage: tuple[float, float]) -> None:
        self.scale = min(PIXELS, WIDEST / stage[0])
        self.middle = (SIDE + stage[0] * self.scale / 2, TOP + stage[1] * self.scale / 2)
        self.width = 2 * SIDE + stage[0] * self.scale
        self.height = TOP + BOTTOM + stage[1] * self.scale

    def to_pixels(self, x: float, z: float) -> svg.Point:
        return self.x(x), self.y(z)

    def x(self, x: float) -> float:
        return self.middle[0] + x * self.scale

    def y(self, z: float) -> float:
        return self.middle[1] + z * self.scale


def draw_formation(
    formation: Formation,
    stage: tuple[float, float],
    *,
    paths: Sequence[Float64] = (),
    outside: Sequence[int] = (),
    title: str = "",
    under: str = "",
) -> str:
    """Return the SVG of a formation on a stage (width, depth) [m].

    `paths`: the path of each dancer into their slot, each (K, 2) [m]; an empty ring marks its start. Slots in `outside`
    get a red ring. `title` is above, `under` below the picture.
    """
    floor = _FloorScale(stage)
    parts = _stage(floor, stage)
    for points in formation.lines:
        parts.append(_polyline([floor.to_pixels(x, z) for x, z in points], DRAWN))
    if formation.symmetry is not None:
        parts += _axis(floor, formation.symmetry, stage)
    for way in paths:
        parts += _path(floor, way)
    for n, (x, z) in enumerate(formation.slots):
        parts += _dancer(floor, formation, n, float(x), float(z), n in outside)
    parts.append(_text(SIDE, 30, title[:80], 18, INK))
    for row, line in enumerate(under.splitlines()[:2]):
        parts.append(_text(SIDE, floor.height - 22 + 15 * row, line[:130], 12, "#666666"))
    return svg.drawing(floor.width, floor.height, parts)


def _axis(floor: _FloorScale, line: SymmetryLine, stage: tuple[float, float]) -> list[str]:
    """Draw the part of the symmetry line that is on the stage."""
    along = np.linspace(-1.0, 1.0, 2001)[:, None] * (math.hypot(*stage) + float(np.hypot(*line.point))) * line.direction
    points = line.point + along
    points = points[(np.abs(points) <= np.array(stage) / 2 + 1e-9).all(axis=1)]
    if len(points) < 2:
        return []
    ends = [floor.to_pixels(*points[0]), floor.to_pixels(*points[-1])]
    return [_polyline(ends, AXIS, stroke_width=1.2, stroke_dasharray="7 5")]


def _stage(floor: _FloorScale, stage: tuple[float, float]) -> list[str]:
    width, depth = stage
    left, right, back, front = floor.x(-width / 2), floor.x(width / 2), floor.y(-depth / 2), floor.y(depth / 2)
    box = {"x": left, "y": back, "width": width * floor.scale, "height": depth * floor.scale}
    parts = [svg.element("rect", **box, fill=FLOOR, stroke=INK, stroke_width=1.5)]
    step = 1 if max(stage) <= 16 else 2 if max(stage) <= 32 else 10
    first, last = math.ceil(-width / 2 / step), math.ceil(-depth / 2 / step)
    for n in range(first, -first + 1):
        x = floor.x(n * step)
        parts.append(_grid_line((x, back), (x, front), n))
        parts.append(_text(x, front + 13, f"{n * step}", 10, "#888888", "middle"))
    for n in range(last, -last + 1):
        y = floor.y(n * step)
        parts.append(_grid_line((left, y), (right, y), n))
        parts.append(_text(left - 6, y + 4, f"{n * step}", 10, "#888888", "end"))
    parts.append(_text(right, front + 27, "public below, metres", 11, "#888888", "end"))
    return parts


def _grid_line(a: svg.Point, b: svg.Point, number: int) -> str:
    ends = {"x1": a[0], "y1": a[1], "x2": b[0], "y2": b[1]}
    return svg.element("line", **ends, stroke=FAINT, stroke_width=1 if number else 1.6)


def _dancer(floor: _FloorScale, formation: Formation, n: int, x: float, z: float, outside: bool) -> list[str]:
    """Draw a dancer with a tip in facing direction; soloists red with a dark ring, `outside` with a red ring."""
    soloist = bool(formation.soloist[n])
    colour = SOLOIST if soloist else SECTIONS[max(int(formation.section[n]), 0) % len(SECTIONS)]
    heading = float(formation.heading[n])
    radius = BODY * floor.scale * 0.8
    corners = [
        floor.to_pixels(x + far * math.sin(heading + side), z + far * math.cos(heading + side))
        for far, side in ((0.42, 0.0), (0.2, 1.1), (0.2, -1.1))
    ]
    parts = [
        svg.element("polygon", points=svg.point_list(corners), fill=colour),
        svg.circle(floor.to_pixels(x, z), radius, fill=colour, **{"class": "soloist" if soloist else "dancer"}),
    ]
    if soloist or outside:
        ring = SOLOIST if outside else INK
        parts.append(svg.circle(floor.to_pixels(x, z), radius + 3, fill="none", stroke=ring, stroke_width=1.5))
    return parts


def _path(floor: _FloorScale, way: Float64) -> list[str]:
    points = [floor.to_pixels(float(x), float(z)) for x, z in way]
    ring = svg.circle(points[0], 0.5 * BODY * floor.scale, fill="white", stroke=WAY, stroke_width=1.5)
    return [_polyline(points, WAY, **{"class": "way"}), ring]


def _polyline(points: Sequence[svg.Point], colour: str, **attributes: svg.Attribute) -> str:
    style: dict[str, svg.Attribute] = {"fill": "none", "stroke": colour, "stroke_width": 1.5}
    return svg.element("polyline", points=svg.point_list(points), **(style | attributes))


def _text(x: float, y: float, words: str, size: int, colour: str, anchor: str = "start") -> str:
    return svg.text(x, y, words, font_size=size, fill=colour, text_anchor=anchor)
