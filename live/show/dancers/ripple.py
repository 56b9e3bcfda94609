"""Ripple: a delay that runs over a group, from one side of the stage to the other or outward from a point (T051)."""

import re
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError

Float64 = npt.NDArray[np.float64]

SIDES: Final = {"left": (1.0, 0.0), "right": (-1.0, 0.0), "back": (0.0, 1.0), "front": (0.0, -1.0)}
"""Where a ripple may begin, as the audience sees it, and the way (x, z) that it then runs."""
NARROW: Final = 0.5
"""A group narrower than this [m] is taken to be so wide: standing on one spot it does not flicker."""
STEP: Final = 1.0 / 16.0
"""Delays are multiples of this many beats."""
_NUMBER: Final = r"[+-]?[0-9]{1,3}(?:\.[0-9]{1,6})?"
_POINT: Final = re.compile(rf"({_NUMBER})[ ,]+({_NUMBER})")


@dataclass(frozen=True, slots=True)
class Ripple:
    """How a group's dancers are late after one another."""

    beats: float = 0.0
    """From the first dancer to the last; 0: nobody is late."""
    side: str = "left"
    """The side where it begins, or "centre" for the group's middle, or "" for a point."""
    point: tuple[float, float] = (0.0, 0.0)
    """That point (x, z) [m]."""

    def delays(self, place: Float64) -> Float64:
        """How late dancers at `place` (n, 2) [m] are [beats], shape (n,)."""
        if self.beats == 0.0 or len(place) < 2:
            return np.zeros(len(place))
        if self.side in SIDES:
            way = place @ np.array(SIDES[self.side])
        else:
            origin = place.mean(axis=0) if self.side == "centre" else np.array(self.point)
            way = np.hypot(*(place - origin).T)
        way = way - way.min()
        return np.asarray(np.round(self.beats / STEP * way / max(float(way.max()), NARROW)) * STEP)


def parse_ripple(words: str, beats: float) -> Ripple:
    """The ripple of so many `beats` that begins where the words say; PersonError if they mean no place."""
    said = " ".join(words.casefold().split())
    if said in SIDES or said == "centre":
        return Ripple(beats, said)
    if match := _POINT.fullmatch(said):
        return Ripple(beats, "", (float(match[1]), float(match[2])))
    raise PersonError(
        f"a ripple cannot begin at {words[:60]!r}",
        "say left, right, front, back, centre, or x z in metres as in '0 -2'",
    )
