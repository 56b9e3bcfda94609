"""Pressure: how hard it is for the machine to keep up, as one number for whoever can draw less."""

from typing import Final

HALFLIFE: Final = 2.0
"""After so many seconds a late frame counts half."""
FULL: Final = 0.1
"""This share of late frames is all the pressure there is: a dance that stutters."""


class Pressure:
    """0 where every frame is in time, 1 where a tenth of them or more is late, or the machine has far too much to do.

    Thread: the show's.
    """

    def __init__(self) -> None:
        self._share = 0.0
        self._late = 0
        self._overload = 0.0

    @property
    def value(self) -> float:
        """0 to 1."""
        return max(min(self._share / FULL, 1.0), self._overload)

    def frame(self, late: int, seconds: float, overload: float = 0.0) -> None:
        """After each frame: `late` frames since the start, and how long this one took from the last one [s].

        `overload`: 0 to 1, what whoever watches over the show feels of a machine that has too much to do.
        """
        self._overload = overload
        kept = 0.5 ** (max(seconds, 0.0) / HALFLIFE)
        now = 1.0 if late > self._late else 0.0
        self._late = late
        self._share = kept * self._share + (1.0 - kept) * now
