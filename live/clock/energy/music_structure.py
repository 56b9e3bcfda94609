"""Structure: build-ups, which rise over several beats, and drops, with which the bass comes back."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.energy.energy_frames import Heard

Float64 = npt.NDArray[np.float64]

SPANS: Final = (4, 8, 16)
"""Beats over which a build-up is looked for."""

RISE_DB: Final = 6.0
RISE_OCTAVES: Final = 0.7
RISE_DENSITY: Final = 1.0
"""What a whole build-up gains: loudness, brightness, onsets a second (in octaves: doubled)."""

MOST_DENSITY: Final = 0.7
"""Onsets are counted badly: they count for so much at most ..."""

LEAST: Final = 0.5
"""... and the other two must rise by this."""

STEADY: Final = 0.6
"""More than this share of a rise within one beat is a step, and no build-up."""

STRAIGHT: Final = 0.5
"""Share of what happens that the straight rise must explain (R²)."""

BUILT: Final = 0.5
"""From here on a build-up counts."""

GONE_DB: Final = 8.0
"""A bass this much weaker is gone ..."""

BACK_DB: Final = 7.0
"""... and this near to the strongest it is back."""

CARRIES_DB: Final = 12.0
"""A bass that much softer than the whole carries nothing: what is lowest in a tune without bass comes and goes."""

BUILT_BEATS: Final = 4
"""Beats without bass that make a break after a build-up of eight or more ..."""

BREAK_BEATS: Final = 7
"""... and without one, if before them, too,"""

GROOVE_BEATS: Final = 8
GROOVE_WITH: Final = 6
"""of so many beats so many had the bass: whose bass comes and goes has no drops. (A piece that builds up before it ever
had a bass drops as well.)"""

AGAIN: Final = 16
"""Beats from one drop to the next at least."""

SILENT_DB: Final = -60.0
"""Music is louder."""

NOTHING_DB: Final = -200.0
"""The bass of beats that never were."""

FORGET: Final = 16
"""Beats of silence after which another piece begins."""

REMEMBERED: Final = 64
"""Beats: a break is no longer."""


class Structure:
    """Takes what every beat was like, in order."""

    def __init__(self) -> None:
        self._beats = np.zeros((max(SPANS), 3))
        self._low = np.full(REMEMBERED, NOTHING_DB)
        self._count = 0
        self._bass = SILENT_DB
        self._built = 0
        self._since_drop = AGAIN
        self._silent = 0
        self.build = 0.0
        """How far a build-up has come, 0 to 1."""
        self.drop = False
        """Whether the bass came back with the last beat."""

    def add(self, heard: Heard) -> None:
        """One more beat."""
        if heard.loudness < SILENT_DB:
            self._silent += 1
            if self._silent >= FORGET:
                self._count, self._bass, self._built = 0, SILENT_DB, 0
            self.build, self.drop = 0.0, False
            return
        self._silent = 0
        density = np.log2(max(heard.onsets, 0.5) / max(heard.seconds, 0.1))
        self._beats = np.roll(self._beats, -1, axis=0)
        self._beats[-1] = heard.loudness, heard.octave, density
        before = self._low.copy()
        self._low = np.roll(self._low, -1)
        self._low[-1] = heard.low
        self._count += 1
        self._since_drop += 1
        self.drop = heard.low > heard.loudness - CARRIES_DB and self._drops(before, heard.low)
        self._bass = max(self._bass - 0.05, heard.low)
        if self.drop:
            self._since_drop = self._built = 0
            self._count = 1  # what was before is no part of what builds up now
            self.build = 0.0
            return
        rising = [self._rising(span) for span in SPANS if self._count >= span]
        long = max(rising[1:], default=0.0)
        self.build = max(rising, default=0.0)
        self._built = 4 if long >= BUILT else max(self._built - 1, 0)

    def _drops(self, before: Float64, low: float) -> bool:
        """Whether the bass `low` [dB] comes back now; `before`: that of the beats before, oldest first."""
        there = max(self._bass - BACK_DB, SILENT_DB)
        if self._since_drop < AGAIN or low < there:
            return False
        without = before < low - GONE_DB
        gone = REMEMBERED if without.all() else int(np.argmin(without[::-1]))
        gone = min(gone, self._count - 1)
        if gone < BUILT_BEATS:
            return False
        groove = before[-gone - GROOVE_BEATS : -gone]
        steady = int(np.count_nonzero(groove >= there)) >= GROOVE_WITH
        if self._built:
            return steady or gone >= max(self._count - 1, AGAIN)
        return gone >= BREAK_BEATS and steady

    def _rising(self, span: int) -> float:
        """How far a build-up has come over the last `span` beats, 0 to 1."""
        beats = self._beats[-span:]
        loudness, octave, density = (beats - beats[0]).T
        heard = loudness / RISE_DB + octave / RISE_OCTAVES
        score = heard + np.clip(density / RISE_DENSITY, -MOST_DENSITY, MOST_DENSITY)
        x = np.arange(span) - 0.5 * (span - 1)
        slope = float(x @ score) / float(x @ x)
        whole = slope * (span - 1)
        least = LEAST * float(x @ x) / (span - 1)
        if float(x @ heard) < least or float(x @ loudness) < 0.0 or whole <= 0.0:  # brighter and softer is a break
            return 0.0
        rest = score - score.mean() - slope * x
        spread = float(np.sum(np.square(score - score.mean())))
        straight = 1.0 - float(rest @ rest) / spread if spread > 0.0 else 0.0
        if straight < STRAIGHT or float(np.diff(score).max()) > STEADY * whole:
            return 0.0
        return min(0.5 * whole, 1.0)
