"""Test cards: what a projector shows while it is set up, and the words that stand on it."""

from typing import Final, Literal, get_args

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from live.render.typeface import readable

Card = Literal["off", "grid", "bars", "name", "safe", "focus", "qr"]
CARDS: Final[tuple[Card, ...]] = get_args(Card)
"""By their numbers in the shader; `off` is the picture, `qr` what an audience joins by (`join_card`)."""

TINTS: Final = ((1.0, 1.0, 1.0), (0.45, 0.9, 1.0), (1.0, 0.85, 0.35), (0.95, 0.55, 1.0), (0.6, 1.0, 0.5))
"""Colours of the outputs' cards in turn, so that lines that overlap can be told apart."""

JOIN: Final = "qr"
"""It is no test card: the key that goes through them leaves it out."""
_HEIGHT: Final = 160


def next_card(card: Card) -> Card:
    """The card after this one; the picture after the last."""
    cards = [each for each in CARDS if each != JOIN]
    return cards[(cards.index(card) + 1) % len(cards)] if card in cards else "off"


def words_of(name: str, detail: str) -> npt.NDArray[np.uint8]:
    """The output's name over a smaller line, white on black: coverage, row 0 on top, shape (160, W)."""
    large, small = ImageFont.load_default(size=92), ImageFont.load_default(size=38)
    shown = readable("".join(letter if letter.isprintable() else "?" for letter in name))
    detail = readable(detail)
    width = round(max(large.getlength(shown), small.getlength(detail))) + 16
    image = Image.new("L", (width, _HEIGHT))
    draw = ImageDraw.Draw(image)
    draw.text((width // 2, 54), shown, fill=255, font=large, anchor="mm")
    draw.text((width // 2, 134), detail, fill=200, font=small, anchor="mm")
    return np.array(image, np.uint8)
