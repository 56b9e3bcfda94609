"""Text for the overlay: a glyph atlas of one font and size, and layout of lines with it.

The font is Pillow's default, which has no accented letters; they are replaced by plain ones.
"""

import unicodedata
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from live.base.arrays import Float32

Font = ImageFont.FreeTypeFont | ImageFont.ImageFont

_REPLACEMENTS: Final = {
    "ß": "ss", "ø": "o", "Ø": "O", "æ": "ae", "Æ": "AE", "œ": "oe", "Œ": "OE", "ł": "l", "Ł": "L",
    "–": "-", "—": "-",
}  # fmt: skip
"""Letters that Unicode does not decompose, and their replacements."""


@cache
def has_glyph(letter: str) -> bool:
    """Whether the font has this letter; a missing one would be drawn as a box."""
    font, box = _font_and_box()
    return letter.isprintable() and (letter == " " or _glyph_mask(font, letter) != box)


@cache
def _font_and_box() -> tuple[Font, tuple[tuple[int, int], bytes]]:
    """Return the font, and the mask of the box that it draws for a missing letter."""
    font = ImageFont.load_default(size=20)
    return font, _glyph_mask(font, "\uffff")


def without_accents(words: str) -> str:
    """Return the text without the accents that the font lacks: `Dança` becomes `Danca`."""
    return "".join(letter if has_glyph(letter) else _without_accent(letter) for letter in words)


def plain_letter(letter: str) -> str:
    """Return a letter without its accent, as `C` for `Ç`, or the letters that usually replace it."""
    return _REPLACEMENTS.get(letter) or unicodedata.normalize("NFKD", letter)[0]


def _without_accent(letter: str) -> str:
    plain = plain_letter(letter)
    return plain if all(map(has_glyph, plain)) else "?"


def _glyph_mask(font: Font, letter: str) -> tuple[tuple[int, int], bytes]:
    mask = font.getmask(letter)
    return mask.size, bytes(mask)


_CODES: Final = tuple(range(32, 127)) + tuple(range(160, 256))
_COLUMNS: Final = 16
_UNKNOWN: Final = "?"


@dataclass(frozen=True, slots=True, eq=False)
class GlyphAtlas:
    """A glyph atlas of one font at one size."""

    coverage: npt.NDArray[np.uint8]
    """Coverage, 0 to 255, top row first, shape (H, W)."""
    cell: tuple[int, int]
    """Width and height of each letter's cell [pixels]."""
    advance: dict[str, float]
    """How far each letter moves the pen [pixels]."""
    index: dict[str, int]
    """Cell of each letter, counted row by row."""

    def lay_out(self, lines: tuple[str, ...], corner: tuple[float, float], limit: int) -> Float32:
        """Return rectangles (x, y, u, v) of at most `limit` letters, one row each, from a corner [pixels, y down].

        (u, v) is the upper left texel of the letter's cell. Missing accents are removed, and unknown letters become
        question marks.
        """
        rows: list[tuple[float, float, float, float]] = []
        for number, line in enumerate(lines):
            x, y = corner[0], corner[1] + number * self.cell[1]
            for letter in without_accents(line):
                known = letter if letter in self.index else _UNKNOWN
                cell = self.index[known]
                if known != " " and len(rows) < limit:
                    u, v = cell % _COLUMNS * self.cell[0], cell // _COLUMNS * self.cell[1]
                    rows.append((round(x), y, u, v))
                x += self.advance[known]
        return np.array(rows, np.float32).reshape(-1, 4)

    def width(self, line: str) -> float:
        """Return the length of a line of text [pixels]."""
        return sum(self.advance[letter if letter in self.index else _UNKNOWN] for letter in without_accents(line))


def bake_atlas(height: int) -> GlyphAtlas:
    """Bake the atlas for letters `height` pixels high."""
    font = ImageFont.load_default(size=height)
    letters = [chr(code) for code in _CODES if has_glyph(chr(code))]
    boxes = [font.getbbox(one) for one in letters]
    width = int(np.ceil(max(box[2] for box in boxes))) + 2
    tall = int(np.ceil(max(box[3] for box in boxes))) + 2
    image = Image.new("L", (width * _COLUMNS, tall * (-(-len(letters) // _COLUMNS))))
    draw = ImageDraw.Draw(image)
    for cell, one in enumerate(letters):
        draw.text((cell % _COLUMNS * width + 1, cell // _COLUMNS * tall), one, fill=255, font=font)
    advance = {one: float(font.getlength(one)) for one in letters}
    digit = max(advance[one] for one in "0123456789")
    advance.update(dict.fromkeys("0123456789", digit))  # changing numbers must not move the rest of the line
    return GlyphAtlas(np.array(image, np.uint8), (width, tall), advance, {one: i for i, one in enumerate(letters)})
