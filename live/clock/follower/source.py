"""Source: what all kinds of clock sources have: a state, a grid of beats, and where its measures begin."""

import math
from dataclasses import dataclass
from typing import Final, Literal, Protocol

from live.clock.follower.level import Level
from live.clock.follower.said import Said
from live.clock.grid import Grid

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
