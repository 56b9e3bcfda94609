"""The gallery: six seconds of each show in patches/, and a longer film of the first show."""

import math
from dataclasses import dataclass
from typing import Final

from live.control.events.cues import Go
from tools.docs_films.film_file import SIZE, Picture
from tools.docs_films.stage_play import film_stage, load, seconds_of

LOOP_S: Final = 6.0
LOOP_SIZE: Final = (480, 270)
"""Of loops that stand side by side [pixels]."""
SPARE_S: Final = 0.6
"""A loop may be so much shorter than it should be, if it then has whole measures."""


@dataclass(frozen=True, slots=True)
class Excerpt:
    """A part of a show: its patch, and the measure (from 1) with which it begins."""

    patch: str
    measure: float
    go: tuple[float, ...] = ()
    """Measures at which somebody says GO."""


EXCERPTS: Final = {
    "first-show": Excerpt("patches/first_show.toml", 24),
    "ballet": Excerpt("patches/ballet/show.toml", 22),
    "barre": Excerpt("patches/barre/show.toml", 22),
    "contemporary": Excerpt("patches/contemporary/show.toml", 22.6),
    "cues": Excerpt("patches/cues/show.toml", 4.5, (1.0, 2.5, 4.9)),
    "folk": Excerpt("patches/folk/show.toml", 5),
    "formations": Excerpt("patches/formations/show.toml", 9.5),
    "hiphop": Excerpt("patches/hiphop/show.toml", 5),
    "house": Excerpt("patches/house/show.toml", 7),
    "lindy": Excerpt("patches/lindy/show.toml", 14),
    "pairs": Excerpt("patches/pairs/show.toml", 6),
    "partner": Excerpt("patches/partner.toml", 4),
    "release": Excerpt("patches/release/show.toml", 15),
    "salsa": Excerpt("patches/salsa/show.toml", 13),
    "samba": Excerpt("patches/samba/show.toml", 4),
    "score": Excerpt("patches/score/show.toml", 10),
    "tap": Excerpt("patches/tap/show.toml", 26),
    "waltz": Excerpt("patches/waltz/show.toml", 7),
}


def draw_excerpt(name: str, seconds: float = LOOP_S, size: tuple[int, int] = LOOP_SIZE) -> list[Picture]:
    """Return about so many seconds of a show, in whole measures."""
    excerpt = EXCERPTS[name]
    loaded = load(excerpt.patch)
    measure = seconds_of(loaded, 1.0)
    begin = (excerpt.measure - 1.0) * measure
    events = [Go(time=(at - 1.0) * measure, source="film") for at in excerpt.go]
    return film_stage(loaded, begin, math.ceil((seconds - SPARE_S) / measure) * measure, events=events, size=size)


def draw_first_show() -> list[Picture]:
    """Return the first show for some eleven seconds: the soloist is left, all spread, and a star begins."""
    return draw_excerpt("first-show", 11.0, SIZE)
