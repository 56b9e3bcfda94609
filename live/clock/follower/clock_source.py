"""Clock sources: their names, interface, validated beat observations, and the mapping from source to danced beats."""

import math
from dataclasses import dataclass
from typing import Final, Literal, Protocol, get_args

from live.clock.timeline import Grid

SourceName = Literal["link", "midi", "mtc", "map", "audio", "tap", "internal"]
PRIORITY: Final[tuple[SourceName, ...]] = get_args(SourceName)
"""All sources, the first in rank first. A source that nothing in this program makes is always absent."""

PERIOD_MIN: Final = 60.0 / 400.0
PERIOD_MAX: Final = 4.0
"""Range of periods accepted from sources [s]."""

AHEAD: Final = 5.0
BEHIND: Final = 5.0
"""Maximum distance of a reported beat from now [s]; enough for the slowest beat."""


@dataclass(frozen=True, slots=True)
class BeatObservation:
    """A beat at `time` [s], `period` [s] to the next; the other fields if the source has them."""

    time: float
    period: float
    confidence: float
    """0 to 1."""
    beat: int = -1
    """Position in its measure, from 0; -1: unknown."""
    beats_per_measure: int = 0
    """0: unknown."""
    measure: int = -1
    """The source's own number of the measure, from 0; -1: unknown."""
    jump: bool = False
    """Whether the source reports a jump."""
    anchored: bool = True
    """False: the beats are even, but their phase is arbitrary."""
    runner_up: int = 0
    """By how many beats later measures would begin on the most likely other line; 0: unknown."""
    runner_up_share: float = 0.0
    """Its probability, 0 to 1."""

    def plausible(self, now: float) -> bool:
        """Whether the values are plausible at `now` [s]; NaN and infinity never are."""
        if not all(map(math.isfinite, (self.time, self.period, self.confidence, self.runner_up_share, now))):
            return False
        if not (PERIOD_MIN <= self.period <= PERIOD_MAX and -BEHIND <= self.time - now <= AHEAD):
            return False
        known = self.beats_per_measure
        if not (0 <= self.runner_up <= max(known - 1, 0) and 0.0 <= self.runner_up_share <= 1.0):
            return False
        return 0 <= known <= 64 and -1 <= self.beat < (known or 64) and -1 <= self.measure < 1 << 40


FACTORS = (0.25, 0.5, 1.0, 2.0, 4.0)
"""Danced beats per source beat."""


class BeatMapping:
    """The affine map from a source's beats to danced beats: exact, without drift.

    danced = (beat - pivot_in) * factor + pivot_out.
    """

    def __init__(self) -> None:
        self.factor = 1.0
        self._pivot_in = 0.0
        self._pivot_out = 0.0

    def map_beat(self, beat: float) -> float:
        """Return the danced beat for a source beat."""
        return (beat - self._pivot_in) * self.factor + self._pivot_out

    def map_grid(self, grid: Grid) -> Grid:
        """Return the grid of danced beats for a source grid."""
        danced = self.map_beat(float(grid.number))
        number = math.floor(danced)
        period = grid.period / self.factor
        return Grid(grid.time - (danced - number) * period, period, number)

    def scale(self, factor: float, danced: float) -> bool:
        """Multiply the danced beats by `factor`; the beat `danced` is kept. False if that is out of range."""
        if self.factor * factor not in FACTORS:
            return False
        self._pivot_in += (danced - self._pivot_out) / self.factor
        self._pivot_out = danced
        self.factor *= factor
        return True

    def shift(self, beats: float) -> None:
        """Move danced beats later by this many beats."""
        self._pivot_out -= beats

    def align_to_beats(self) -> None:
        """Move danced beats back onto the source's beats."""
        self._pivot_in = math.floor(self._pivot_in + 0.5)
        self._pivot_out = math.floor(self._pivot_out + 0.5)

    def reset(self, beat: float, danced: float) -> None:
        """Use every source beat; continue numbering from `danced` at the source's present `beat`."""
        self.factor = 1.0
        self._pivot_in = math.floor(beat)
        self._pivot_out = math.floor(danced - (beat - self._pivot_in) + 0.5)

    def pin(self, beat: float, danced: float, factor: float) -> None:
        """Map `factor` danced beats to one source beat, where the source's `beat` is the danced beat `danced`."""
        self.factor, self._pivot_in, self._pivot_out = factor, beat, danced

    def fold(self, tempo: float, lowest: float, highest: float) -> None:
        """Halve or double the danced beats of a source of `tempo` [bpm] into the range, if possible."""
        while tempo * self.factor > highest and self.factor > FACTORS[0] and tempo * self.factor / 2.0 >= lowest:
            self.scale(0.5, self._pivot_out)
        while tempo * self.factor < lowest and self.factor < FACTORS[-1] and tempo * self.factor * 2.0 <= highest:
            self.scale(2.0, self._pivot_out)


State = Literal["absent", "listening", "following", "locked"]
"""absent: never received, or gone; listening: present, but without accepted beats; following: accepted, not yet sure;
locked: sure.
"""

OFFSET_MAX: Final = 0.5
"""Maximum sum of the nudges of one source [s]."""


@dataclass(frozen=True, slots=True)
class Lines:
    """Measure lines: at danced beat `beat` of a source and every `spacing` beats; `votes`: consecutive
    confirmations. `runner_up`: by how many beats later the most likely others are, 0 if unknown, and their
    probability."""

    beat: float
    spacing: float
    votes: float
    runner_up: float = 0.0
    runner_up_share: float = 0.0


class Source(Protocol):
    """One clock source. Times are seconds of the show; the numbering of beats is the source's own."""

    name: str
    state: State
    confidence: float
    jumped: bool
    """Whether it has reported a jump; reset by the code that handles it."""

    @property
    def ready(self) -> bool:
        """Whether its grid can be followed."""
        ...

    def grid(self) -> Grid | None:
        """Return its danced beats; None before the first."""
        ...

    def lines(self) -> Lines | None:
        """Return its measure lines; None if unknown."""
        ...

    def check_timeout(self, now: float) -> None:
        """Detect missing beats."""
        ...


class ObservedSource:
    """Base class of sources that receive observations, through `observe`, `silent`, `lost` …"""

    def __init__(self, name: str) -> None:
        self.name = name
        self.state: State = "absent"
        self.confidence = 0.0
        self.observed_at = -math.inf
        """Time of the last observation [s]."""
        self.silent_since: float | None = None
        self.jumped = False
        self.offset = 0.0
        """Sum of nudges, positive is later [s]."""
        self.level = BeatMapping()
        """Mapping to danced beats."""
        self.detail = ""

    @property
    def ready(self) -> bool:
        """Whether its grid can be followed."""
        return self.state in ("following", "locked")

    def raw(self) -> Grid | None:
        """Return its own beats."""
        return None

    def grid(self) -> Grid | None:
        """Return its danced beats, nudged."""
        raw = self.raw()
        if raw is None:
            return None
        danced = self.level.map_grid(raw)
        return Grid(danced.time + self.offset, danced.period, danced.number)

    def lines(self) -> Lines | None:
        """Return its measure lines in danced beats."""
        own = self.own_lines()
        if own is None:
            return None
        beat, spacing = self.level.map_beat(own.beat), own.spacing * self.level.factor
        if abs(beat - round(beat)) > 0.01 or abs(spacing - round(spacing)) > 0.01:
            return None
        later = own.runner_up * self.level.factor
        share = own.runner_up_share if later == round(later) else 0.0
        return Lines(float(round(beat)), float(round(spacing)), own.votes, later if share else 0.0, share)

    def own_lines(self) -> Lines | None:
        """Return its measure lines in its own beats."""
        return None

    def nudge(self, seconds: float) -> None:
        """Move its danced beats later by this many seconds."""
        self.offset = min(max(self.offset + seconds, -OFFSET_MAX), OFFSET_MAX)

    def observe(self, said: BeatObservation, now: float) -> None:
        """Process a plausible observation, received at `now` [s]."""
        raise NotImplementedError

    def silent(self, now: float) -> None:
        """Handle silence: later observations of earlier beats are ignored."""
        self.silent_since = now if self.silent_since is None else self.silent_since
        self.state = "listening"

    def paused(self, now: float) -> None:
        """Handle a pause longer than usual; by default the same as silence."""
        self.silent(now)

    def lost(self, now: float) -> None:
        """Handle the loss of the source."""
        self.silent(now)
        self.state = "absent"

    def found(self, now: float) -> None:
        """Handle its return."""
        self.silent_since = None
        if self.state == "absent":
            self.state = "listening"

    def precedes_silence(self, said: BeatObservation) -> bool:
        """Whether an observation is of a time before the silence."""
        return self.silent_since is not None and said.time <= self.silent_since

    def check_timeout(self, now: float) -> None:
        """Detect missing beats."""
