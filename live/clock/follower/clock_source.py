"""Source: what all kinds of clock sources have: a state, a grid of beats, and where its measures begin.

Said: one statement of a source about where the beat is, checked before anything believes it.

Level: which beats of a source are danced: all, every second one, or also those between, and how far off.
"""

import math
from dataclasses import dataclass
from typing import Final, Literal, Protocol

from live.clock.timeline import Grid

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


FACTORS = (0.25, 0.5, 1.0, 2.0, 4.0)
"""Danced beats for one of the source."""


class Level:
    """The affine map from a source's beats to danced ones: exact, and without drift however long it runs.

    danced = (beat - pivot_in) * factor + pivot_out.
    """

    def __init__(self) -> None:
        self.factor = 1.0
        self._pivot_in = 0.0
        self._pivot_out = 0.0

    def danced(self, beat: float) -> float:
        """The danced beat for a beat of the source."""
        return (beat - self._pivot_in) * self.factor + self._pivot_out

    def grid(self, grid: Grid) -> Grid:
        """The grid of danced beats for one of the source's."""
        danced = self.danced(float(grid.number))
        number = math.floor(danced)
        period = grid.period / self.factor
        return Grid(grid.time - (danced - number) * period, period, number)

    def scale(self, factor: float, danced: float) -> bool:
        """`factor` times as many danced beats; the beat `danced` is one in both. False if that is beyond bounds."""
        if self.factor * factor not in FACTORS:
            return False
        self._pivot_in += (danced - self._pivot_out) / self.factor
        self._pivot_out = danced
        self.factor *= factor
        return True

    def shift(self, beats: float) -> None:
        """Danced beats lie so many beats later."""
        self._pivot_out -= beats

    def straighten(self) -> None:
        """Danced beats lie on the source's again."""
        self._pivot_in = math.floor(self._pivot_in + 0.5)
        self._pivot_out = math.floor(self._pivot_out + 0.5)

    def reset(self, beat: float, danced: float) -> None:
        """Every beat is danced; the numbers go on from `danced`, which is where the source's `beat` is now."""
        self.factor = 1.0
        self._pivot_in = math.floor(beat)
        self._pivot_out = math.floor(danced - (beat - self._pivot_in) + 0.5)

    def pin(self, beat: float, danced: float, factor: float) -> None:
        """`factor` danced beats for one of the source, whose `beat` is the danced beat `danced`."""
        self.factor, self._pivot_in, self._pivot_out = factor, beat, danced

    def fold(self, tempo: float, lowest: float, highest: float) -> None:
        """Halve or double what is danced of a source of `tempo` [bpm] into the range, where that can be."""
        while tempo * self.factor > highest and self.factor > FACTORS[0] and tempo * self.factor / 2.0 >= lowest:
            self.scale(0.5, self._pivot_out)
        while tempo * self.factor < lowest and self.factor < FACTORS[-1] and tempo * self.factor * 2.0 <= highest:
            self.scale(2.0, self._pivot_out)


State = Literal["absent", "listening", "following", "locked"]
"""absent: never heard, or gone; listening: there, but it says nothing that is believed; following: believed, not yet
sure; locked: sure."""

OFFSET_MAX: Final = 0.5
"""Nudges of one source add up to at most this [s]."""


@dataclass(frozen=True, slots=True)
class Lines:
    """A measure begins at danced beat `beat` of a source, and every `spacing` beats; `votes`: how often running."""

    beat: float
    spacing: float
    votes: float


class Source(Protocol):
    """One clock source. Times are seconds of the show; beats are numbered as the source likes."""

    name: str
    state: State
    confidence: float
    jumped: bool
    """Whether it has said that it jumped; whoever takes that up sets it back."""

    @property
    def ready(self) -> bool:
        """Whether its grid may be run after."""
        ...

    def grid(self) -> Grid | None:
        """Its danced beats; None before any were heard."""
        ...

    def lines(self) -> Lines | None:
        """Where its measures begin; None where it does not know."""
        ...

    def watch(self, now: float) -> None:
        """Notice that nothing comes any more."""
        ...


class HeardSource:
    """What sources that are heard have in common: their statements come in through `heard`, `silent`, `lost` …"""

    def __init__(self, name: str) -> None:
        self.name = name
        self.state: State = "absent"
        self.confidence = 0.0
        self.heard_at = -math.inf
        """When it was last heard [s]."""
        self.silent_since: float | None = None
        self.jumped = False
        self.offset = 0.0
        """Nudged so much later [s]."""
        self.level = Level()
        """Which of its beats are danced."""
        self.detail = ""

    @property
    def ready(self) -> bool:
        """Whether its grid may be run after."""
        return self.state in ("following", "locked")

    def raw(self) -> Grid | None:
        """Its own beats."""
        return None

    def grid(self) -> Grid | None:
        """Its danced beats, nudged."""
        raw = self.raw()
        if raw is None:
            return None
        danced = self.level.grid(raw)
        return Grid(danced.time + self.offset, danced.period, danced.number)

    def lines(self) -> Lines | None:
        """Where its measures begin, in danced beats."""
        own = self.own_lines()
        if own is None:
            return None
        beat, spacing = self.level.danced(own.beat), own.spacing * self.level.factor
        if abs(beat - round(beat)) > 0.01 or abs(spacing - round(spacing)) > 0.01:
            return None
        return Lines(float(round(beat)), float(round(spacing)), own.votes)

    def own_lines(self) -> Lines | None:
        """Where its measures begin, in its own beats."""
        return None

    def nudge(self, seconds: float) -> None:
        """Its beats are danced so much later [s]."""
        self.offset = min(max(self.offset + seconds, -OFFSET_MAX), OFFSET_MAX)

    def heard(self, said: Said, now: float) -> None:
        """A plausible statement, received at `now` [s]."""
        raise NotImplementedError

    def silent(self, now: float) -> None:
        """Nothing is played: what is said of beats before is no news."""
        self.silent_since = now if self.silent_since is None else self.silent_since
        self.state = "listening"

    def paused(self, now: float) -> None:
        """It rests for longer than usual; a source that is not told apart in that falls silent."""
        self.silent(now)

    def lost(self, now: float) -> None:
        """It went away."""
        self.silent(now)
        self.state = "absent"

    def found(self, now: float) -> None:
        """It is there again; what comes now is judged afresh."""
        self.silent_since = None
        if self.state == "absent":
            self.state = "listening"

    def too_late(self, said: Said) -> bool:
        """Whether a statement was on its way when silence fell."""
        return self.silent_since is not None and said.time <= self.silent_since

    def watch(self, now: float) -> None:
        """Notice that nothing comes any more."""
