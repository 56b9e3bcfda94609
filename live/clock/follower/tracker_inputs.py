"""Inputs from audio trackers: a consensus for plain beat trackers (aubio), and smoothing for bar pointers.

A bar pointer's tempo, beat and measure are accepted. The input removes its jitter and single outliers (fills), and
changes over at once when several observations agree on something else (a new tempo).
"""

import math
from typing import Final

from live.clock.beat_estimate import Consensus, TempoPrior, WeightedBeat
from live.clock.follower.beat_kalman_filter import BeatFilter
from live.clock.follower.clock_source import BeatObservation, Lines
from live.clock.timeline import Grid

CHALLENGE: Final = 1.3
"""A grid that contradicts the present one needs more support by this factor, from ..."""

CHALLENGE_SPAN: Final = 2.0
"""... at least three estimates over at least this many seconds: one decision of a tracker may look like several."""

SAME_BEATS: Final = 0.1
"""Beats within this [beats] are the same. It must not exceed the distance within which `Consensus` lets estimates
support a grid, or a grid could be neither confirmed nor replaced.
"""

MANUAL_OCTAVES: Final = 0.15
KNOWN_OCTAVES: Final = 0.12
"""Width of the prior around a tempo that was tapped, typed or written in the score [octaves]."""


class ConsensusInput:
    """Finds the grid on which the estimates of the last seconds agree."""

    def __init__(self, grid: Grid, known_tempo: float | None = None) -> None:
        """`grid` is used until there are beats; `known_tempo` [bpm] settles the octave."""
        self.grid = grid
        self._prefer = TempoPrior() if known_tempo is None else TempoPrior(known_tempo, KNOWN_OCTAVES)
        self._consensus = Consensus()
        self._first = True
        self.share = 0.0
        """Share of the recent estimates that agree with the grid, 0 to 1."""
        self.is_confirmed = False
        """Whether several estimates since the last `clear` support the grid."""

    @property
    def sure(self) -> bool:
        """Whether most of the recent estimates agree."""
        return self.is_confirmed and self.share >= 0.5 and len(self._consensus) >= 4

    def clear(self) -> None:
        """Reset the estimates."""
        self._consensus.clear()
        self.is_confirmed = False

    def set_grid(self, grid: Grid) -> None:
        """Set the beats by hand, including which half beat is the beat."""
        self.grid = grid
        self._prefer = TempoPrior(grid.tempo, MANUAL_OCTAVES)
        self._consensus.clear()

    def keep_half_beats(self) -> None:
        """Let estimates half a beat off support the grid too: a tap has decided which of the two is the beat."""
        self._consensus.half_beats = True

    def observe(self, said: BeatObservation, now: float, *, decide: bool) -> None:
        """Add an observation and, unless manual settings have priority, decide on the grid."""
        self._consensus.add(WeightedBeat(said.time, said.period, 0.3 + 0.7 * min(max(said.confidence, 0.0), 1.0)), now)
        if decide:
            self._decide(now)

    def _decide(self, now: float) -> None:
        """Keep and refine the grid, or replace it by another one that several estimates support."""
        consensus = self._consensus
        support, share = consensus.support(self.grid, now)
        support *= self._prefer.weight(self.grid.period)
        best, best_support = self.grid, support
        for grid in consensus.candidates():
            value = consensus.support(grid, now)[0] * self._prefer.weight(grid.period)
            if value > best_support:
                best, best_support = grid, value
        if not self._same(best) and self._is_stronger(best, best_support, support):
            kept = consensus.half_beats and abs(math.log(self.grid.tempo / best.tempo)) < 0.15
            self.grid = best.numbered_like(self.grid.beat_at(now), now)
            consensus.half_beats = kept
            self._first, self.is_confirmed = False, True
        elif len(consensus.supporting_estimates(self.grid)) >= (3 if self._first else 2):
            self._refine(now)
            self._first, self.is_confirmed = False, True
        self.share = consensus.support(self.grid, now)[1] if self.is_confirmed else share

    def _same(self, grid: Grid) -> bool:
        tempo = abs(math.log(grid.period / self.grid.period)) < 0.04
        return tempo and abs(self.grid.residual(grid.time)) < SAME_BEATS

    def _is_stronger(self, grid: Grid, value: float, present: float) -> bool:
        witnesses = self._consensus.supporting_estimates(grid)
        if len(witnesses) < 3 or value < CHALLENGE * present:
            return False
        return self._first or witnesses[-1].time - witnesses[0].time >= CHALLENGE_SPAN

    def _refine(self, now: float) -> None:
        fitted = self._consensus.fit(self.grid, now)
        number = math.floor(fitted.beat_at(now))
        self.grid = Grid(fitted.time + (number - fitted.number) * fitted.period, fitted.period, number)


AGREED: Final = 3
AGREED_SURE: Final = 2
SURE: Final = 0.6
"""Number of observations that contradict the beats but agree with each other after which they replace the beats; fewer
if all have the confidence `SURE`.
"""

AGREES_BEATS: Final = 0.15
AGREES_TEMPO: Final = 0.06
"""Maximum difference of two observations that agree (beats; relative)."""

SHARE_MEMORY: Final = 0.2
"""Weight of the newest observation in the share that fits."""


class BarPointerInput:
    """Smooths the observations of a tracker with a bar pointer."""

    def __init__(self) -> None:
        self._filter: BeatFilter | None = None
        self._suspects: list[BeatObservation] = []
        self._line: float | None = None
        self._beats = 0
        self._votes = 0
        self._voted = -1
        self._runner_up = (0.0, 0.0)
        self.share = 0.0
        """Share of the recent observations that fitted, weighted by confidence, 0 to 1."""
        self.restarts = 0
        """Number of times the beats were replaced by others."""

    @property
    def grid(self) -> Grid | None:
        """The tracker's beats; None before the first."""
        return None if self._filter is None else self._filter.grid

    @property
    def is_confirmed(self) -> bool:
        """Whether several observations agree."""
        return self._filter is not None and self._filter.updates >= 2

    @property
    def sure(self) -> bool:
        """Whether many observations agree with high confidence."""
        return self._filter is not None and self._filter.updates >= 4 and self.share >= 0.5

    def clear(self) -> None:
        """Reset the input."""
        self._filter, self._line = None, None
        self._suspects.clear()
        self.share = 0.0

    def observe(self, said: BeatObservation) -> None:
        """Process an observation: it fits, or is kept as a suspect until others agree with it."""
        if self._filter is None:
            self._start(said, 0)
            return
        fits = self._filter.update(said.time, said.period, said.confidence)
        self.share += SHARE_MEMORY * ((0.3 + 0.7 * said.confidence if fits else 0.0) - self.share)
        if fits:
            self._suspects.clear()
            self._vote(said)
            return
        if self._suspects and not _agree(self._suspects[-1], said):
            self._suspects.clear()
        if self._suspects and abs(said.time - self._suspects[-1].time) < 0.3 * said.period:
            self._suspects.pop()  # the same beat, reported again
        self._suspects.append(said)
        sure = min(suspect.confidence for suspect in self._suspects) >= SURE
        if len(self._suspects) >= (AGREED_SURE if sure else AGREED):
            self._adopt_suspects()

    def lines(self) -> Lines | None:
        """Return the tracker's measure lines."""
        if self._line is None:
            return None
        return Lines(self._line, float(self._beats), float(self._votes), *self._runner_up)

    def _start(self, said: BeatObservation, number: int) -> None:
        self._filter = BeatFilter(said.time, said.period, said.confidence, number)
        self.share = 0.3 + 0.7 * said.confidence
        self._line, self._votes = None, 0
        self._vote(said)

    def _adopt_suspects(self) -> None:
        """Replace the beats by the suspects, with continued numbering."""
        assert self._filter is not None
        first, *others = self._suspects
        number = math.floor(self._filter.grid.beat_at(first.time) + 0.5)
        self._start(first, number)
        for said in others:
            self._filter.update(said.time, said.period, said.confidence)
            self._vote(said)
        self._suspects.clear()
        self.restarts += 1

    def _vote(self, said: BeatObservation) -> None:
        """Count the consecutive beats with the same measure line; a repeated beat counts once."""
        assert self._filter is not None
        if said.beat < 0 or said.beats_per_measure < 1:
            return
        number = self._filter.number
        line, again = number - said.beat, number == self._voted and self._line is not None
        same = self._line is not None and self._beats == said.beats_per_measure
        same = same and (line - self._line) % said.beats_per_measure == 0  # type: ignore[operator]
        if not same:
            self._votes = 1
        elif not again:
            self._votes += 1
        self._line, self._beats, self._voted = float(line), said.beats_per_measure, number
        self._runner_up = float(said.runner_up), said.runner_up_share


def _agree(one: BeatObservation, other: BeatObservation) -> bool:
    """Whether two observations are of the same beats."""
    if abs(math.log(other.period / one.period)) > AGREES_TEMPO:
        return False
    return abs(Grid(one.time, 0.5 * (one.period + other.period)).residual(other.time)) < AGREES_BEATS
