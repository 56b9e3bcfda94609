"""ConsensusEar: statements of a tracker that hears single beats (aubio): the grid that they have in common."""

import math
from typing import Final

from live.clock.consensus import Consensus, Heard, Preference
from live.clock.follower.said import Said
from live.clock.grid import Grid

CHALLENGE: Final = 1.3
"""A grid that contradicts the present one needs this much more support, from ..."""

CHALLENGE_SPAN: Final = 2.0
"""... at least three estimates over at least these seconds: one decision of a tracker may sound like several."""

SAME_BEATS: Final = 0.1
"""Beats within this [beats] are the same; farther apart than `Consensus` lets estimates speak for a grid it must not
be, or a grid could be neither confirmed by what is heard nor give way to it."""

HAND_OCTAVES: Final = 0.15
KNOWN_OCTAVES: Final = 0.12
"""How narrowly a tempo that somebody tapped, typed or wrote down rules the choice of octave."""


class ConsensusEar:
    """Which grid the estimates of the last seconds mean."""

    def __init__(self, grid: Grid, known_tempo: float | None = None) -> None:
        """`grid` is what is run while nothing is heard; `known_tempo` [bpm] settles the octave."""
        self.grid = grid
        self._prefer = Preference() if known_tempo is None else Preference(known_tempo, KNOWN_OCTAVES)
        self._consensus = Consensus()
        self._first = True
        self.share = 0.0
        """The share of what was lately heard that agrees with the grid, 0 to 1."""
        self.believed = False
        """Whether several estimates since the last `clear` mean the grid."""

    @property
    def sure(self) -> bool:
        """Whether most of what was heard agrees."""
        return self.believed and self.share >= 0.5 and len(self._consensus) >= 4

    def clear(self) -> None:
        """What comes now is judged afresh."""
        self._consensus.clear()
        self.believed = False

    def take(self, grid: Grid) -> None:
        """The hand says what the beat is, and which of the half beats."""
        self.grid = grid
        self._prefer = Preference(grid.tempo, HAND_OCTAVES)
        self._consensus.clear()

    def keep_half_beats(self) -> None:
        """Estimates half a beat off speak for the grid, too: somebody tapped which of the two is the beat."""
        self._consensus.half_beats = True

    def heard(self, said: Said, now: float, *, decide: bool) -> None:
        """Remember a statement, and unless the hand rules decide what all say together."""
        self._consensus.add(Heard(said.time, said.period, 0.3 + 0.7 * min(max(said.confidence, 0.0), 1.0)), now)
        if decide:
            self._decide(now)

    def _decide(self, now: float) -> None:
        """Keep the grid and refine it, or take another that several estimates agree on."""
        consensus = self._consensus
        support, share = consensus.support(self.grid, now)
        support *= self._prefer.of(self.grid.period)
        best, best_support = self.grid, support
        for grid in consensus.candidates():
            value = consensus.support(grid, now)[0] * self._prefer.of(grid.period)
            if value > best_support:
                best, best_support = grid, value
        if not self._same(best) and self._convinces(best, best_support, support):
            kept = consensus.half_beats and abs(math.log(self.grid.tempo / best.tempo)) < 0.15
            self.grid = best.numbered_like(self.grid.beat_at(now), now)
            consensus.half_beats = kept
            self._first, self.believed = False, True
        elif len(consensus.witnesses(self.grid)) >= (3 if self._first else 2):
            self._refine(now)
            self._first, self.believed = False, True
        self.share = consensus.support(self.grid, now)[1] if self.believed else share

    def _same(self, grid: Grid) -> bool:
        tempo = abs(math.log(grid.period / self.grid.period)) < 0.04
        return tempo and abs(self.grid.residual(grid.time)) < SAME_BEATS

    def _convinces(self, grid: Grid, value: float, present: float) -> bool:
        witnesses = self._consensus.witnesses(grid)
        if len(witnesses) < 3 or value < CHALLENGE * present:
            return False
        return self._first or witnesses[-1].time - witnesses[0].time >= CHALLENGE_SPAN

    def _refine(self, now: float) -> None:
        fitted = self._consensus.fitted(self.grid, now)
        number = math.floor(fitted.beat_at(now))
        self.grid = Grid(fitted.time + (number - fitted.number) * fitted.period, fitted.period, number)
