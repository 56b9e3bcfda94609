"""The typeface of what is lettered: Pillow's own, which has no letters with accents. Words in it stay readable."""

import unicodedata
from functools import cache
from typing import Final

from PIL import ImageFont

_APART: Final = {
    "ß": "ss", "ø": "o", "Ø": "O", "æ": "ae", "Æ": "AE", "œ": "oe", "Œ": "OE", "ł": "l", "Ł": "L",
}  # fmt: skip
"""Letters that no accent was put on, and what stands for them."""


@cache
def has(letter: str) -> bool:
    """Whether the typeface has this letter; what it lacks it draws as a box."""
    font = ImageFont.load_default(size=20)
    return letter.isprintable() and (letter == " " or _ink(font, letter) != _ink(font, "\uffff"))


def readable(words: str) -> str:
    """The words without the accents that the typeface lacks: `Dança` as `Danca`, not as a box in `Dan a`."""
    return "".join(letter if has(letter) else _without_accent(letter) for letter in words)


def _without_accent(letter: str) -> str:
    plain = _APART.get(letter) or unicodedata.normalize("NFKD", letter)[0]
    return plain if all(map(has, plain)) else "?"


def _ink(font: "ImageFont.FreeTypeFont | ImageFont.ImageFont", letter: str) -> tuple[tuple[int, int], bytes]:
    mask = font.getmask(letter)
    return mask.size, bytes(mask)
