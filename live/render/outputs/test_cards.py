"""Test cards: what a projector shows while it is set up, and the words that stand on it."""

from typing import Final, Literal, get_args

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

Card = Literal["off", "grid", "bars", "name", "safe", "focus"]
CARDS: Final[tuple[Card, ...]] = get_args(Card)
"""By their numbers in the shader; `off` is the picture."""

TINTS: Final = ((1.0, 1.0, 1.0), (0.45, 0.9, 1.0), (1.0, 0.85, 0.35), (0.95, 0.55, 1.0), (0.6, 1.0, 0.5))
"""Colours of the outputs' cards in turn, so that lines that overlap can be told apart."""

_HEIGHT: Final = 160


def next_card(card: Card) -> Card:
    """The card after this one; the picture after the last."""
    return CARDS[(CARDS.index(card) + 1) % len(CARDS)]


def words_of(name: str, detail: str) -> npt.NDArray[np.uint8]:
    """The output's name over a smaller line, white on black: coverage, row 0 on top, shape (160, W)."""
    large, small = ImageFont.load_default(size=92), ImageFont.load_default(size=38)
    shown = "".join(letter if letter.isprintable() else "?" for letter in name)
    width = round(max(large.getlength(shown), small.getlength(detail))) + 16
    image = Image.new("L", (width, _HEIGHT))
    draw = ImageDraw.Draw(image)
    draw.text((width // 2, 54), shown, fill=255, font=large, anchor="mm")
    draw.text((width // 2, 134), detail, fill=200, font=small, anchor="mm")
    return np.array(image, np.uint8)
