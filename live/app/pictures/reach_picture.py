"""Drawing of a step's reachable region from above (Fig 5.7b), and canvases for SVG and PNG."""

import io
import math
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from live.app.pictures import svg
from live.app.pictures.svg import Point
from live.base.arrays import Float64
from live.graph.select.reachability import ARC, DIRECTION_NAMES, Reach

SIZE: Final = 720
"""Width and height of the picture in pixels."""
TOP: Final = 64
"""Pixels above the picture for its title."""
SECTORS: Final = 72
LONGEST_NAME: Final = 40
INK, FAINT, TURNED, MIXED, CLIP, MISSING = "#222222", "#d9d9d9", "#e3ecf7", "#7fa8d9", "#1f4e8c", "#c03030"


class Canvas(Protocol):
    """Drawing surface; points in pixels, y downwards."""

    def polygon(self, points: list[Point], fill: str) -> None:
        """Draw a filled polygon."""

    def line(self, a: Point, b: Point, colour: str, width: float, dashed: bool = False) -> None:
        """Draw a straight line."""

    def circle(self, centre: Point, radius: float, fill: str | None, colour: str | None = None) -> None:
        """Draw a circle, filled or outlined."""

    def text(self, at: Point, words: str, size: int, colour: str, anchor: str = "start") -> None:
        """Draw text whose start, middle or end is at the point, on its base line."""


@dataclass(frozen=True, slots=True)
class _Scale:
    """Conversion of metres in the dancer's frame (x left, z ahead) to pixels: ahead is up, left is left."""

    metres: float
    """Distance from the centre to the edge [m]."""

    def to_pixels(self, way: Float64 | Point) -> Point:
        pixels = 0.42 * SIZE / self.metres
        return SIZE / 2 - pixels * float(way[0]), TOP + SIZE / 2 - pixels * float(way[1])

    def radius(self, metres: float) -> float:
        return 0.42 * SIZE / self.metres * metres


def draw_reach(reach: Reach, canvas: Canvas) -> None:
    """Draw rings every quarter or half metre, the region with turns, mixtures, clips, and missing directions."""
    everything = np.concatenate([reach.clips, reach.mixed, reach.turned.reshape(-1, 2)])
    scale = _Scale(max(0.25, 1.05 * float(np.hypot(*everything.T).max(initial=0.0))))
    canvas.polygon([scale.to_pixels(way) for way in outline(reach.turned.reshape(-1, 2))], TURNED)
    ring = 0.25 if scale.metres <= 1.0 else 0.5
    for n in range(1, int(scale.metres / ring) + 1):
        canvas.circle(scale.to_pixels((0.0, 0.0)), scale.radius(n * ring), None, FAINT)
        x, y = scale.to_pixels((0.0, -n * ring))
        canvas.text((x + 4, y - 3), f"{n * ring:g} m", 12, "#888888")
    for way in reach.mixed:
        canvas.circle(scale.to_pixels(way), 2.5, MIXED)
    for way in reach.clips:
        canvas.line(scale.to_pixels((0.0, 0.0)), scale.to_pixels(way), CLIP, 1.0)
        canvas.circle(scale.to_pixels(way), 5.0, CLIP)
    _draw_missing(reach, scale, canvas)
    x, y = scale.to_pixels((0.0, 0.0))
    canvas.polygon([(x, y - 13), (x - 8, y + 8), (x + 8, y + 8)], INK)  # the dancer faces up
    canvas.text((16, 28), f"{reach.step[:LONGEST_NAME]}: where one measure leads", 19, INK)
    words = "large dots: clips, small: mixtures, shaded: turned by up to 90°"
    canvas.text((16, 50), words + ("; red: nothing recorded" if reach.missing else ""), 12, "#555555")


def _draw_missing(reach: Reach, scale: _Scale, canvas: Canvas) -> None:
    """Draw a dashed line in every direction without clips."""
    for name in reach.missing:
        angle = DIRECTION_NAMES.index(name) * ARC
        end = (0.97 * scale.metres * math.sin(angle), 0.97 * scale.metres * math.cos(angle))
        canvas.line(scale.to_pixels((0.0, 0.0)), scale.to_pixels(end), MISSING, 1.5, dashed=True)
        x, y = scale.to_pixels(end)
        side = "middle" if abs(end[0]) < 0.1 * scale.metres else ("end" if x < SIZE / 2 else "start")
        canvas.text((x, y + (14 if end[1] < -0.1 * scale.metres else -6)), name, 12, MISSING, side)


def outline(positions: Float64) -> list[Point]:
    """Return the region's border: the farthest of `positions` (n, 2) from the centre in each of `SECTORS` sectors."""
    heading = np.arctan2(positions[:, 0], positions[:, 1])
    sector = np.round(heading / (2.0 * math.pi) * SECTORS).astype(np.int64) % SECTORS
    radius = np.zeros(SECTORS)
    np.maximum.at(radius, sector, np.hypot(*positions.T))
    angles = np.arange(SECTORS) / SECTORS * 2.0 * math.pi
    return [(float(r * math.sin(a)), float(r * math.cos(a))) for r, a in zip(radius, angles, strict=True)]


class SvgCanvas:
    """Collects SVG elements; `size` in pixels."""

    def __init__(self, size: tuple[int, int] = (SIZE, SIZE + TOP)) -> None:
        self._size = size
        self._parts: list[str] = []

    def polygon(self, points: list[Point], fill: str) -> None:
        self._parts.append(svg.element("polygon", points=svg.point_list(points), fill=fill))

    def line(self, a: Point, b: Point, colour: str, width: float, dashed: bool = False) -> None:
        ends = {"x1": a[0], "y1": a[1], "x2": b[0], "y2": b[1]}
        dash = "6 5" if dashed else None
        self._parts.append(svg.element("line", **ends, stroke=colour, stroke_width=width, stroke_dasharray=dash))

    def circle(self, centre: Point, radius: float, fill: str | None, colour: str | None = None) -> None:
        self._parts.append(svg.circle(centre, radius, fill=fill or "none", stroke=colour or "none"))

    def text(self, at: Point, words: str, size: int, colour: str, anchor: str = "start") -> None:
        self._parts.append(svg.text(*at, words, font_size=size, fill=colour, text_anchor=anchor))

    def data(self) -> bytes:
        """The file."""
        return svg.drawing(*self._size, self._parts).encode()


class PngCanvas:
    """Draws with Pillow at twice the size and scales down at the end, for smooth edges."""

    FINE = 2

    def __init__(self, size: tuple[int, int] = (SIZE, SIZE + TOP)) -> None:
        from PIL import Image, ImageDraw

        self._size = size
        self._image = Image.new("RGB", (self.FINE * size[0], self.FINE * size[1]), "white")
        self._draw = ImageDraw.Draw(self._image)

    def polygon(self, points: list[Point], fill: str) -> None:
        self._draw.polygon([(self.FINE * x, self.FINE * y) for x, y in points], fill=fill)

    def line(self, a: Point, b: Point, colour: str, width: float, dashed: bool = False) -> None:
        length = math.dist(a, b)
        cuts = np.arange(0.0, length, 11.0) if dashed else np.zeros(1)
        for begin in cuts:
            end = min(begin + 6.0, length) if dashed else length
            ends = [
                tuple(self.FINE * (a[n] + (b[n] - a[n]) * part / max(length, 1e-9)) for n in (0, 1))
                for part in (begin, end)
            ]
            self._draw.line([*ends[0], *ends[1]], fill=colour, width=max(1, round(self.FINE * width)))

    def circle(self, centre: Point, radius: float, fill: str | None, colour: str | None = None) -> None:
        x, y, r = self.FINE * centre[0], self.FINE * centre[1], self.FINE * radius
        self._draw.ellipse((x - r, y - r, x + r, y + r), fill=fill, outline=colour, width=self.FINE)

    def text(self, at: Point, words: str, size: int, colour: str, anchor: str = "start") -> None:
        from PIL import ImageFont

        from live.render.lettering.glyph_atlas import without_accents

        font, words = ImageFont.load_default(self.FINE * size), without_accents(words)
        place = {"start": "ls", "middle": "ms", "end": "rs"}[anchor]
        self._draw.text((self.FINE * at[0], self.FINE * at[1]), words, fill=colour, font=font, anchor=place)

    def data(self) -> bytes:
        """The file."""
        buffer = io.BytesIO()
        self._image.resize(self._size, resample=3).save(buffer, "PNG")
        return buffer.getvalue()
