"""What the music says about the measure line, apart from where the line is: the runner-up that an operator may take.

A line that was set by hand stays. Whether the music agrees is counted here beside it: for each beat of the measure, how
often it sounded like the first of one in the last measures.
"""

import math
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.clock.bar_pointer.metre import MAX_METRE

MEMORY_MEASURES: Final = 10.0
"""Time constant of the memory [measures]."""
USUAL: Final = 0.25
"""Share of beats that are downbeats."""
LEAST_SAID, MOST_SAID = 0.03, 0.97
"""Limits of the probability that a beat is a downbeat."""
LEAST_BEAT: Final = 0.1
"""A beat that sounded less than this says nothing."""
INDEPENDENCE: Final = 0.4
"""Share of the evidence that counts: neighbouring measures of one song are alike."""


class LineEvidence:
    """Log-odds of each beat of the measure to be its first, over the last measures."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget all that was heard."""
        self._score: Float64 = np.zeros(MAX_METRE)
        self._metre = 0
        self._beats = 0
        self._loudest = self._first = 0.0
        self._in_window = False

    @property
    def measures(self) -> float:
        """Measures heard since the last `clear` and change of metre."""
        return self._beats / self._metre if self._metre else 0.0

    def step(self, in_window: bool, metre: int, beat: int, said_beat: float, said_downbeat: float) -> None:
        """Process a frame: whether it lies in the window of the beat `beat` of a measure of `metre`, and the
        probabilities of a beat and of a downbeat in it."""
        if in_window:
            if not self._in_window:
                self._loudest = self._first = 0.0
            if said_beat > self._loudest:
                self._loudest = said_beat
            self._first = max(self._first, said_downbeat)
        elif self._in_window:
            self._count(metre, beat)
        self._in_window = in_window

    def _count(self, metre: int, beat: int) -> None:
        if metre != self._metre:
            self._score[:] = 0.0
            self._metre, self._beats = metre, 0
        self._beats += 1
        self._score[beat] *= 1.0 - 1.0 / MEMORY_MEASURES
        if self._loudest < LEAST_BEAT:
            return
        first = min(max(self._first / self._loudest, LEAST_SAID), MOST_SAID)
        self._score[beat] += math.log(first / (1.0 - first)) - math.log(USUAL / (1.0 - USUAL))

    def shares(self) -> Float64:
        """Return the probability of each line: measures begin where they do, or so many beats later, (metre,)."""
        if self._metre < 2:
            return np.zeros(0)
        score = INDEPENDENCE * self._score[: self._metre]
        share = np.exp(score - score.max())
        return np.asarray(share / share.sum())

    @property
    def runner_up(self) -> tuple[int, float]:
        """The most likely other line: by how many beats later measures would begin, and its probability, 0 to 1."""
        share = self.shares()
        if share.size == 0:
            return 0, 0.0
        other = 1 + int(np.argmax(share[1:]))
        return other, float(share[other])
