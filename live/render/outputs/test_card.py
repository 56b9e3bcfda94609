"""Test cards for projector set-up, and the join card of the audience (QR code, link and invitation)."""

from collections.abc import Sequence
from typing import Final, Literal, get_args

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from live.render.lettering.glyph_atlas import without_accents

Card = Literal["off", "grid", "bars", "name", "safe", "focus", "qr"]
CARDS: Final[tuple[Card, ...]] = get_args(Card)
"""In the order of their numbers in the shader; `off` is the picture, `qr` the join card (`join_card`)."""

TINTS: Final = ((1.0, 1.0, 1.0), (0.45, 0.9, 1.0), (1.0, 0.85, 0.35), (0.95, 0.55, 1.0), (0.6, 1.0, 0.5))
"""Colours of the outputs' cards in turn, to distinguish overlapping lines."""

JOIN_CARD: Final = "qr"
"""Not a test card: the key that cycles through the cards skips it."""
_HEIGHT: Final = 160


def next_card(card: Card) -> Card:
    """Return the next card; the picture after the last."""
    cards = [each for each in CARDS if each != JOIN_CARD]
    return cards[(cards.index(card) + 1) % len(cards)] if card in cards else "off"


def render_label(name: str, detail: str) -> npt.NDArray[np.uint8]:
    """Render the output's name above a smaller line, white on black: coverage, row 0 on top, shape (160, W)."""
    large, small = ImageFont.load_default(size=92), ImageFont.load_default(size=38)
    shown = without_accents("".join(letter if letter.isprintable() else "?" for letter in name))
    detail = without_accents(detail)
    width = round(max(large.getlength(shown), small.getlength(detail))) + 16
    image = Image.new("L", (width, _HEIGHT))
    draw = ImageDraw.Draw(image)
    draw.text((width // 2, 54), shown, fill=255, font=large, anchor="mm")
    draw.text((width // 2, 134), detail, fill=200, font=small, anchor="mm")
    return np.array(image, np.uint8)


def render_digits() -> npt.NDArray[np.uint8]:
    """Render 0 to 9 beside each other, each in a cell of 48 x 80 pixels: coverage, row 0 on top, shape (80, 480)."""
    image = Image.new("L", (480, 80))
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(size=68)
    for digit in range(10):
        draw.text((48 * digit + 24, 40), str(digit), fill=255, font=font, anchor="mm")
    return np.array(image, np.uint8)


MODULE_SIZE: Final = 14
"""Pixels per module of the QR code."""
QUIET_ZONE: Final = 4
"""Width of the quiet zone in modules (ISO/IEC 18004)."""
INVITATION: Final = "Dance with us  ·  Vem bailar connosco"
_TEXT: Final = 44
BAND_HEIGHT: Final = 84
"""Height of a line of text [pixels]."""


def join_card(code: Sequence[str], link: str) -> npt.NDArray[np.uint8]:
    """Render the join card: brightness, row 0 on top, shape (H, W). `code`: rows of "0" and "1"; the link is below."""
    modules = np.array([[letter == "1" for letter in row] for row in code], np.bool_).reshape(len(code), -1)
    modules = np.pad(modules, QUIET_ZONE)
    picture = np.kron(np.where(modules, 0, 255).astype(np.uint8), np.ones((MODULE_SIZE, MODULE_SIZE), np.uint8))
    words = [_fit_font(words, picture.shape[1] - 2 * MODULE_SIZE * QUIET_ZONE) for words in (INVITATION, link)]
    bands = [_band(text, font, picture.shape[1]) for text, font in words]
    return np.concatenate(
        [bands[0], picture[MODULE_SIZE * (QUIET_ZONE - 2) : -MODULE_SIZE * (QUIET_ZONE - 2)], bands[1]]
    )


def _fit_font(words: str, width: int) -> tuple[str, "ImageFont.FreeTypeFont | ImageFont.ImageFont"]:
    """Return the text and the largest font in which it fits into `width`."""
    size = _TEXT
    while size > 10 and ImageFont.load_default(size=size).getlength(words) > width:
        size -= 2
    return words, ImageFont.load_default(size=size)


def _band(words: str, font: "ImageFont.FreeTypeFont | ImageFont.ImageFont", width: int) -> npt.NDArray[np.uint8]:
    image = Image.new("L", (width, BAND_HEIGHT), 255)
    ImageDraw.Draw(image).text((width // 2, BAND_HEIGHT // 2), words, fill=0, font=font, anchor="mm")
    return np.array(image, np.uint8)
