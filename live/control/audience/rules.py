"""Rules: what the show tells its gateway: what is allowed, whose turn it is, what is voted for, where the beat is."""

from dataclasses import dataclass
from typing import Final

from live.control.message_codec import registered

SLIPS: Final = 0.010
"""Phones are told the clock anew when the beat would be so far [s] from where they believe it ..."""
AHEAD: Final = 2.0
"""... in so many seconds."""


@registered("rules")
@dataclass(frozen=True, slots=True)
class Rules:
    """Everything but the clock. Beats are the Timeline's."""

    order: int = 0
    open: bool = True
    muted: bool = False
    shake: bool = True
    half: tuple[float, float] = (6.0, 4.0)
    """Half sizes of the stage [m]."""
    regions: tuple[str, ...] = ()
    weights: tuple[float, ...] = ()
    """What each region's voices weigh now."""
    banned: tuple[int, ...] = ()
    turn: tuple[int, float, float] | None = None
    """Region, and from which beat to which."""
    vote: tuple[int, str, tuple[str, ...], float] | None = None
    """Number, what, choices, and the beat at which it closes."""
    won: tuple[int, str] = (0, "")


@registered("beat")
@dataclass(frozen=True, slots=True)
class Beat:
    """Where the beat is: `beat` at `time` [s of the show], and where measures begin."""

    time: float = 0.0
    beat: float = 0.0
    tempo: float = 120.0
    beats_per_measure: int = 4
    line: float = 0.0
    """Beat of a measure line."""

    def at(self, time: float) -> float:
        """The beat at `time` [s]."""
        return self.beat + (time - self.time) * self.tempo / 60.0

    def slipped(self, other: "Beat", now: float) -> bool:
        """Whether `other`, by now or soon, is another beat than this to somebody who dances."""
        apart = max(abs(self.at(t) - other.at(t)) for t in (now, now + AHEAD)) * 60.0 / self.tempo
        metre = self.beats_per_measure != other.beats_per_measure
        turned = (self.line - other.line) % self.beats_per_measure
        return metre or apart > SLIPS or min(turned, self.beats_per_measure - turned) > 0.01
