"""Page model of sheets: lines, shapes and words on paper, in points (1/72 inch) from its upper left corner, y down.

`drawn_pages` draws them as PDF and as pictures, so layout is done once.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, Final

from live.base.errors import PersonError
from live.render.lettering.glyph_atlas import plain_letter

MM: Final = 72.0 / 25.4
"""Points of a millimetre."""
PAPERS: Final = {"a4": (210.0 * MM, 297.0 * MM), "letter": (612.0, 792.0)}
"""Width and height of papers [pt]."""
MARGIN: Final = 15.0 * MM
"""Empty border of every page [pt]."""
SMALL: Final = 8.0
"""Smallest size of letters [pt]."""
TEXT: Final = 8.5
LEADING: Final = 1.3
"""Distance of lines, in sizes of letters."""

Ink = tuple[float, float, float]
"""sRGB, 0 to 1."""
Point = tuple[float, float]


def grey(level: float) -> Ink:
    """Return a grey: 0 is black."""
    return (level, level, level)


BLACK: Final = grey(0.0)
FAINT: Final = grey(0.45)
WHITE: Final = grey(1.0)


@dataclass(frozen=True, slots=True)
class Stroke:
    """A line through points."""

    points: tuple[Point, ...]
    width: float
    ink: Ink
    dash: float = 0.0
    """Length of its dashes [pt]; 0: none."""


@dataclass(frozen=True, slots=True)
class Shape:
    """A filled polygon with an outline."""

    points: tuple[Point, ...]
    fill: Ink | None
    ink: Ink | None
    width: float = 0.6


@dataclass(frozen=True, slots=True)
class Disc:
    """A filled circle with an outline."""

    centre: Point
    radius: float
    fill: Ink | None
    ink: Ink | None
    width: float = 0.6


@dataclass(frozen=True, slots=True)
class Words:
    """A line of words on a baseline."""

    at: Point
    words: str
    size: float
    bold: bool
    ink: Ink
    anchor: str
    """l, m or r: which part of the words is at the point."""


Item = Stroke | Shape | Disc | Words


@dataclass(frozen=True, slots=True)
class SceneArea:
    """Where a page shows a scene; it is not drawn."""

    scene: int
    """Its number, from 1."""
    corner: Point
    """Upper left corner."""
    width: float
    height: float


@dataclass(slots=True)
class Page:
    """One page."""

    width: float
    height: float
    items: list[Item] = field(default_factory=list)
    areas: list[SceneArea] = field(default_factory=list)

    @staticmethod
    def of(paper: str) -> "Page":
        """Return an empty page of a paper of `PAPERS`."""
        return Page(*PAPERS[paper])

    @property
    def inner_width(self) -> float:
        """Width between the margins."""
        return self.width - 2.0 * MARGIN

    def stroke(self, points: Sequence[Point], width: float = 0.6, ink: Ink = BLACK, dash: float = 0.0) -> None:
        """Add a line through points."""
        self.items.append(Stroke(tuple(points), width, ink, dash))

    def shape(self, points: Sequence[Point], fill: Ink | None, ink: Ink | None = BLACK, width: float = 0.6) -> None:
        """Add a polygon."""
        self.items.append(Shape(tuple(points), fill, ink, width))

    def disc(self, centre: Point, radius: float, fill: Ink | None, ink: Ink | None = BLACK, width: float = 0.6) -> None:
        """Add a circle."""
        self.items.append(Disc(centre, radius, fill, ink, width))

    def words(
        self, at: Point, words: str, size: float = TEXT, *, bold: bool = False, ink: Ink = BLACK, anchor: str = "l"
    ) -> None:
        """Add a line of words; letters that the font lacks are replaced."""
        self.items.append(Words(at, known_letters(words), max(size, SMALL), bold, ink, anchor))


@cache
def font_file(bold: bool) -> Path:
    """Return the font of all sheets: Bitstream Vera, which ReportLab brings along and which may be embedded."""
    import reportlab

    path = Path(reportlab.__file__).parent / "fonts" / ("VeraBd.ttf" if bold else "Vera.ttf")
    if not path.is_file():
        raise PersonError(f"the font {path.name} is missing in {path.parent}", "uv pip install --reinstall reportlab")
    return path


@cache
def font_face(bold: bool) -> Any:
    """Return ReportLab's font, with its widths and letters."""
    from reportlab.pdfbase import pdfmetrics
    from reportlab.pdfbase.ttfonts import TTFont

    name = "SheetsBold" if bold else "Sheets"
    font = TTFont(name, str(font_file(bold)))
    pdfmetrics.registerFont(font)
    return font


@cache
def known_letters(words: str) -> str:
    """Return words without the letters that the font lacks: accents are left out, other letters become `?`."""
    known = font_face(False).face.charToGlyph
    return "".join(letter if ord(letter) in known else _replacement(letter, known) for letter in words)


def _replacement(letter: str, known: Any) -> str:
    plain = plain_letter(letter)
    return plain if all(ord(one) in known and ord(one) >= 32 for one in plain) else "?"


@cache
def text_width(words: str, size: float, bold: bool = False) -> float:
    """Return the width of words [pt]."""
    return float(font_face(bold).stringWidth(known_letters(words), size))


def wrapped(words: str, width: float, size: float, bold: bool = False) -> list[str]:
    """Return words in lines of at most this width [pt]; a longer word is cut."""
    lines: list[str] = []
    line = ""
    for word in words.split():
        longer = f"{line} {word}".strip()
        if not line or text_width(longer, size, bold) <= width:
            line = longer
        else:
            lines.append(line)
            line = word
    return [shortened(one, width, size, bold) for one in (*lines, line) if one]


def shortened(words: str, width: float, size: float, bold: bool = False) -> str:
    """Return words cut to a width [pt], with an ellipsis."""
    if text_width(words, size, bold) <= width:
        return words
    while words and text_width(words + "…", size, bold) > width:
        words = words[:-1]
    return words.rstrip() + "…"
