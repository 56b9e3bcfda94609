"""The card that an audience joins by: the code, its link in letters, and what it is for."""

from collections.abc import Sequence
from typing import Final

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

MODULE: Final = 14
"""Pixels of a module of the code."""
QUIET: Final = 4
"""Modules of white around it, which its readers need (ISO/IEC 18004)."""
INVITES: Final = "Dance with us  ·  Vem bailar connosco"
_TEXT: Final = 44
BAND: Final = 84
"""Height of a line of words."""


def join_card(code: Sequence[str], link: str) -> npt.NDArray[np.uint8]:
    """Brightness, row 0 on top, shape (H, W): the code in rows of 0 and 1, words above it, its link below."""
    modules = np.array([[letter == "1" for letter in row] for row in code], np.bool_).reshape(len(code), -1)
    modules = np.pad(modules, QUIET)
    picture = np.kron(np.where(modules, 0, 255).astype(np.uint8), np.ones((MODULE, MODULE), np.uint8))
    words = [_fitted(words, picture.shape[1] - 2 * MODULE * QUIET) for words in (INVITES, link)]
    bands = [_band(text, font, picture.shape[1]) for text, font in words]
    return np.concatenate([bands[0], picture[MODULE * (QUIET - 2) : -MODULE * (QUIET - 2)], bands[1]])


def _fitted(words: str, width: int) -> tuple[str, "ImageFont.FreeTypeFont | ImageFont.ImageFont"]:
    """The words and a font in which they are no wider than that."""
    size = _TEXT
    while size > 10 and ImageFont.load_default(size=size).getlength(words) > width:
        size -= 2
    return words, ImageFont.load_default(size=size)


def _band(words: str, font: "ImageFont.FreeTypeFont | ImageFont.ImageFont", width: int) -> npt.NDArray[np.uint8]:
    image = Image.new("L", (width, BAND), 255)
    ImageDraw.Draw(image).text((width // 2, BAND // 2), words, fill=0, font=font, anchor="mm")
    return np.array(image, np.uint8)
