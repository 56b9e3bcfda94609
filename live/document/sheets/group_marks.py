"""Marks of groups on paper: a shape and a shade for each, with a tint of its colour that has the same shade in grey."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from live.document.sheets.page import BLACK, WHITE, Ink, Page, Point, grey

CIRCLE: Final = 0
_CORNERS: Final = {1: (4, math.pi / 4), 2: (3, 0.0), 3: (4, 0.0), 4: (6, 0.0), 5: (3, math.pi)}
"""Corners of the shapes after the circle, and their turn: square, triangle, diamond, hexagon, triangle downwards."""
_SIZES: Final = {0: 1.0, 1: 1.22, 2: 1.42, 3: 1.28, 4: 1.1, 5: 1.42}
"""Radii that give all shapes about the same size."""
SHAPES: Final = 6
SHADES: Final = (0.96, 0.30, 0.76, 0.52)
"""Lightness of the groups' marks, in turn."""
_LUMA: Final = (0.299, 0.587, 0.114)


@dataclass(frozen=True, slots=True)
class GroupMark:
    """A group's mark."""

    shape: int
    fill: Ink
    ink: Ink
    """Ink of a number in it."""


def marks_of(colours: Sequence[tuple[float, float, float]]) -> list[GroupMark]:
    """Return the marks of groups with these colours (sRGB); up to 24 groups have marks that differ in grey."""
    found = []
    for index, colour in enumerate(colours):
        shade = SHADES[(index + index // (SHAPES * 2)) % len(SHADES)]
        found.append(GroupMark(index % SHAPES, tint(colour, shade), WHITE if shade < 0.6 else BLACK))
    return found


def tint(colour: tuple[float, float, float], shade: float) -> Ink:
    """Return a colour (sRGB), lighter or darker so that it prints as the grey `shade`."""
    soft = [0.6 * one + 0.4 * _grey_of(colour) for one in colour]
    level = _grey_of(soft)
    if level <= 1e-6:
        return grey(shade)
    if level > shade:
        red, green, blue = (one * shade / level for one in soft)
    else:
        share = (shade - level) / max(1.0 - level, 1e-6)
        red, green, blue = (one + share * (1.0 - one) for one in soft)
    return red, green, blue


def _grey_of(colour: Sequence[float]) -> float:
    return sum(weight * one for weight, one in zip(_LUMA, colour, strict=True))


def draw_mark(page: Page, mark: GroupMark, at: Point, radius: float, *, width: float = 0.7, ink: Ink = BLACK) -> None:
    """Draw a mark whose circle has this radius [pt]."""
    if mark.shape == CIRCLE:
        page.disc(at, radius, mark.fill, ink, width)
    else:
        page.shape(outline(mark.shape, at, radius), mark.fill, ink, width)


def outline(shape: int, at: Point, radius: float) -> list[Point]:
    """Return the corners of a shape other than the circle."""
    corners, turn = _CORNERS[shape]
    size = radius * _SIZES[shape]
    drop = radius * {2: 0.2, 5: -0.2}.get(shape, 0.0)  # the number stands in the middle of a triangle
    angles = [turn + 2.0 * math.pi * k / corners for k in range(corners)]
    return [(at[0] + size * math.sin(one), at[1] + drop - size * math.cos(one)) for one in angles]
