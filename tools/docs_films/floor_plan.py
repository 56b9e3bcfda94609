"""The stage seen from above, the audience below: ways, places and dancers, drawn with smooth edges."""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from tools.docs_films.film_file import SIZE, Picture

Colour = tuple[int, int, int]
Points = npt.NDArray[np.floating]

GROUND: Final = (17, 18, 24)
FLOOR: Final = (30, 32, 41)
EDGE: Final = (74, 78, 92)
INK: Final = (232, 232, 228)
FAINT: Final = (128, 131, 143)
SCALE: Final = 3
"""So many pixels are drawn across one."""
DANCER_RADIUS: Final = 0.25
"""Radius of an agent [m]."""


def on_screen(linear: Sequence[float]) -> Colour:
    """Return a linear colour (0 to 1) of a patch as an sRGB colour, a little lighter for small shapes."""
    red, green, blue = (round(255 * min(1.0, 0.06 + value ** (1 / 2.2))) for value in linear)
    return red, green, blue


def mixed(colour: Colour, other: Colour, share: float) -> Colour:
    """Return `colour` with a `share` of `other`."""
    red, green, blue = (round(a + (b - a) * share) for a, b in zip(colour, other, strict=True))
    return red, green, blue


class Canvas:
    """A picture of `size` (width, height) [pixels] to draw on, in its own pixels."""

    def __init__(self, size: tuple[int, int] = SIZE, ground: Colour = GROUND) -> None:
        self.size = size
        self._image = Image.new("RGB", (size[0] * SCALE, size[1] * SCALE), ground)
        self.pen = ImageDraw.Draw(self._image)

    def line(self, points: Sequence[Sequence[float]] | Points, colour: Colour, width: float = 1.5) -> None:
        """Draw a line through points (n, 2)."""
        scaled = [(float(x) * SCALE, float(y) * SCALE) for x, y in points]
        if len(scaled) > 1:
            self.pen.line(scaled, fill=colour, width=max(1, round(width * SCALE)), joint="curve")

    def disc(
        self, at: Sequence[float] | Points, radius: float, colour: Colour | None, rim: Colour | None = None
    ) -> None:
        """Draw a disc, or a ring without `colour`."""
        x, y, r = float(at[0]) * SCALE, float(at[1]) * SCALE, radius * SCALE
        self.pen.ellipse((x - r, y - r, x + r, y + r), fill=colour, outline=rim, width=round(1.6 * SCALE))

    def box(self, corners: Sequence[float], colour: Colour, rim: Colour | None = None, radius: float = 0.0) -> None:
        """Draw a rectangle (left, top, right, bottom)."""
        box = [value * SCALE for value in corners]
        self.pen.rounded_rectangle(box, radius * SCALE, fill=colour, outline=rim, width=SCALE)

    def polygon(self, points: Sequence[Sequence[float]], colour: Colour) -> None:
        """Draw a filled polygon."""
        self.pen.polygon([(x * SCALE, y * SCALE) for x, y in points], fill=colour)

    def ring(self, points: Points, colour: Colour, width: float = 2.0) -> None:
        """Draw a closed line through points (n, 2)."""
        self.line(np.concatenate([points, points[:2]]), colour, width)

    def text(
        self, at: tuple[float, float], words: str, colour: Colour = INK, size: float = 14.0, anchor: str = "lm",
        font: str | None = None,
    ) -> None:  # fmt: skip
        """Write a line of text, in the usual font or in that of a file."""
        drawn = ImageFont.load_default(size * SCALE) if font is None else ImageFont.truetype(font, size * SCALE)
        self.pen.text((at[0] * SCALE, at[1] * SCALE), words, fill=colour, font=drawn, anchor=anchor)

    def paste(self, picture: Picture, corner: tuple[int, int]) -> None:
        """Put a picture there, as it is."""
        image = Image.fromarray(picture)
        image = image.resize((image.width * SCALE, image.height * SCALE), Image.Resampling.NEAREST)
        self._image.paste(image, (corner[0] * SCALE, corner[1] * SCALE))

    def picture(self) -> Picture:
        """Return it."""
        return np.asarray(self._image.reduce(SCALE))


class FloorPlan:
    """The stage of `stage` (width, depth) [m] on a canvas, as large as it fits into `box`."""

    def __init__(self, canvas: Canvas, stage: tuple[float, float], box: tuple[float, float, float, float]) -> None:
        left, top, right, bottom = box
        self.canvas = canvas
        self.metre = min((right - left) / stage[0], (bottom - top) / stage[1])
        self._middle = np.array(((left + right) / 2, (top + bottom) / 2))
        half = np.array(stage) / 2 * self.metre
        canvas.box((*(self._middle - half), *(self._middle + half)), FLOOR, EDGE, 3.0)

    def at(self, places: Points) -> Points:
        """Return places (…, 2) [m] in the canvas's pixels."""
        return self._middle + np.asarray(places, np.float64) * self.metre

    def way(self, places: Points, colour: Colour, width: float = 1.5) -> None:
        """Draw a way (n, 2)."""
        self.canvas.line(self.at(places), colour, width)

    def slot(self, place: Points, colour: Colour = FAINT) -> None:
        """Draw a place where somebody will stand."""
        self.canvas.disc(self.at(place), DANCER_RADIUS * self.metre, None, colour)

    def dancer(self, place: Points, heading: float, colour: Colour) -> None:
        """Draw a dancer: a disc, and a nose that shows where they face."""
        radius = DANCER_RADIUS * self.metre
        middle = self.at(place)
        ahead, side = (
            np.array((math.sin(heading), math.cos(heading))),
            np.array((math.cos(heading), -math.sin(heading))),
        )
        nose = [middle + radius * (0.75 * ahead + 0.6 * side), middle + radius * 1.5 * ahead]
        nose.append(middle + radius * (0.75 * ahead - 0.6 * side))
        self.canvas.polygon([(float(x), float(y)) for x, y in nose], colour)
        self.canvas.disc(middle, radius, colour)
