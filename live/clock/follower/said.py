"""Said: one statement of a source about where the beat is, checked before anything believes it."""

import math
from dataclasses import dataclass
from typing import Final

PERIOD_MIN: Final = 60.0 / 400.0
PERIOD_MAX: Final = 4.0
"""Periods that anybody may name [s]."""

AHEAD: Final = 5.0
BEHIND: Final = 5.0
"""How far from now [s] a beat may lie that somebody names; far enough for the slowest beat."""


@dataclass(frozen=True, slots=True)
class Said:
    """A beat at `time` [s], `period` [s] to the next; the rest where the source knows it."""

    time: float
    period: float
    confidence: float
    """0 to 1."""
    beat: int = -1
    """Which beat of its measure it is, from 0; -1: unknown."""
    beats_per_measure: int = 0
    """0: unknown."""
    measure: int = -1
    """The source's own number of the measure, from 0; -1: unknown."""
    jump: bool = False
    """The source says that it has jumped."""
    anchored: bool = True
    """False: the beats are even, but when a beat is the source cannot tell."""

    def plausible(self, now: float) -> bool:
        """Whether this may be true at `now` [s]; NaN and infinity never are."""
        if not all(map(math.isfinite, (self.time, self.period, self.confidence, now))):
            return False
        if not (PERIOD_MIN <= self.period <= PERIOD_MAX and -BEHIND <= self.time - now <= AHEAD):
            return False
        known = self.beats_per_measure
        return 0 <= known <= 64 and -1 <= self.beat < (known or 64) and -1 <= self.measure < 1 << 40
