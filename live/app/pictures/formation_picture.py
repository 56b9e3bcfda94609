"""SVG drawing of a formation from above, audience below (Fig 4.4 to 4.6)."""

import math
from collections.abc import Sequence
from typing import Final
from xml.sax.saxutils import escape

import numpy as np
import numpy.typing as npt

from live.agents.formations.formation import Formation
from live.agents.formations.symmetry import SymmetryLine

Float64 = npt.NDArray[np.float64]

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

    def to_pixels(self, x: float, z: float) -> str:
        return f"{self.middle[0] + x * self.scale:.1f},{self.middle[1] + z * self.scale:.1f}"

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
    size = f'width="{floor.width:.0f}" height="{floor.height:.0f}"'
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="Helvetica, Arial, sans-serif">']
    parts.append(f'<rect {size} fill="white"/>')
    parts += _stage(floor, stage)
    for points in formation.lines:
        drawn = " ".join(floor.to_pixels(x, z) for x, z in points)
        parts.append(f'<polyline points="{drawn}" fill="none" stroke="{DRAWN}" stroke-width="1.5"/>')
    if formation.symmetry is not None:
        parts.append(_axis(floor, formation.symmetry, stage))
    parts += [_path(floor, way) for way in paths]
    for n, (x, z) in enumerate(formation.slots):
        parts += _dancer(floor, formation, n, float(x), float(z), n in outside)
    parts.append(_text(SIDE, 30, title[:80], 18, INK))
    for row, line in enumerate(under.splitlines()[:2]):
        parts.append(_text(SIDE, floor.height - 22 + 15 * row, line[:130], 12, "#666666"))
    return "\n".join([*parts, "</svg>", ""])


def _axis(floor: _FloorScale, line: SymmetryLine, stage: tuple[float, float]) -> str:
    """Draw the part of the symmetry line that is on the stage."""
    along = np.linspace(-1.0, 1.0, 2001)[:, None] * (math.hypot(*stage) + float(np.hypot(*line.point))) * line.direction
    points = line.point + along
    points = points[(np.abs(points) <= np.array(stage) / 2 + 1e-9).all(axis=1)]
    if len(points) < 2:
        return ""
    ends = f'points="{floor.to_pixels(*points[0])} {floor.to_pixels(*points[-1])}"'
    return f'<polyline {ends} fill="none" stroke="{AXIS}" stroke-width="1.2" stroke-dasharray="7 5"/>'


def _stage(floor: _FloorScale, stage: tuple[float, float]) -> list[str]:
    width, depth = stage
    parts = [
        f'<rect x="{floor.x(-width / 2):.1f}" y="{floor.y(-depth / 2):.1f}" width="{width * floor.scale:.1f}" '
        f'height="{depth * floor.scale:.1f}" fill="{FLOOR}" stroke="{INK}" stroke-width="1.5"/>'
    ]
    step = 1 if max(stage) <= 16 else 2 if max(stage) <= 32 else 10
    left, back = math.ceil(-width / 2 / step), math.ceil(-depth / 2 / step)
    for n in range(left, -left + 1):
        x = floor.x(n * step)
        ends = f'y1="{floor.y(-depth / 2):.1f}" y2="{floor.y(depth / 2):.1f}"'
        parts.append(f'<line x1="{x:.1f}" x2="{x:.1f}" {ends} stroke="{FAINT}" stroke-width="{1 if n else 1.6}"/>')
        parts.append(_text(x, floor.y(depth / 2) + 13, f"{n * step}", 10, "#888888", "middle"))
    for n in range(back, -back + 1):
        y = floor.y(n * step)
        ends = f'x1="{floor.x(-width / 2):.1f}" x2="{floor.x(width / 2):.1f}"'
        parts.append(f'<line y1="{y:.1f}" y2="{y:.1f}" {ends} stroke="{FAINT}" stroke-width="{1 if n else 1.6}"/>')
        parts.append(_text(floor.x(-width / 2) - 6, y + 4, f"{n * step}", 10, "#888888", "end"))
    parts.append(_text(floor.x(width / 2), floor.y(depth / 2) + 27, "public below, metres", 11, "#888888", "end"))
    return parts


def _dancer(floor: _FloorScale, formation: Formation, n: int, x: float, z: float, outside: bool) -> list[str]:
    """Draw a dancer with a tip in facing direction; soloists red with a dark ring, `outside` with a red ring."""
    soloist = bool(formation.soloist[n])
    colour = SOLOIST if soloist else SECTIONS[max(int(formation.section[n]), 0) % len(SECTIONS)]
    heading = float(formation.heading[n])
    radius = BODY * floor.scale * 0.8
    tip = floor.to_pixels(x + 0.42 * math.sin(heading), z + 0.42 * math.cos(heading))
    wings = [
        floor.to_pixels(x + 0.2 * math.sin(heading + side), z + 0.2 * math.cos(heading + side)) for side in (1.1, -1.1)
    ]
    centre = f'cx="{floor.x(x):.1f}" cy="{floor.y(z):.1f}"'
    parts = [
        f'<polygon points="{tip} {wings[0]} {wings[1]}" fill="{colour}"/>',
        f'<circle {centre} r="{radius:.1f}" fill="{colour}" class="{"soloist" if soloist else "dancer"}"/>',
    ]
    if soloist or outside:
        ring = SOLOIST if outside else INK
        parts.append(f'<circle {centre} r="{radius + 3:.1f}" fill="none" stroke="{ring}" stroke-width="1.5"/>')
    return parts


def _path(floor: _FloorScale, way: Float64) -> str:
    points = " ".join(floor.to_pixels(float(x), float(z)) for x, z in way)
    start = f'cx="{floor.x(float(way[0, 0])):.1f}" cy="{floor.y(float(way[0, 1])):.1f}"'
    return (
        f'<polyline points="{points}" fill="none" stroke="{WAY}" stroke-width="1.5" class="way"/>'
        f'<circle {start} r="{0.5 * BODY * floor.scale:.1f}" fill="white" stroke="{WAY}" stroke-width="1.5"/>'
    )


def _text(x: float, y: float, words: str, size: int, colour: str, anchor: str = "start") -> str:
    plain = escape("".join(sign if sign.isprintable() else "?" for sign in words))
    return f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" fill="{colour}" text-anchor="{anchor}">{plain}</text>'
