"""The register of styles: name, family, weight in the mix, and whether it is held out for validation."""

from collections.abc import Callable
from dataclasses import dataclass
from random import Random

from training.music.build import Plan, build
from training.music.piece import Piece

Draw = Callable[[Random], Plan]


@dataclass(frozen=True, slots=True)
class Style:
    """A style: `draw` decides a plan. `held_out` styles are in the validation split only."""

    name: str
    family: str
    weight: float
    held_out: bool
    draw: Draw


STYLES: dict[str, Style] = {}


def style(name: str, family: str, weight: float = 1.0, held_out: bool = False) -> Callable[[Draw], Draw]:
    """Registers a function that draws a plan as a style."""

    def register(draw: Draw) -> Draw:
        STYLES[name] = Style(name, family, weight, held_out, draw)
        return draw

    return register


def compose(rng: Random, name: str, seconds: float) -> Piece:
    """A piece of this style, at least so many seconds long."""
    return build(rng, name, STYLES[name].draw(rng), seconds)
