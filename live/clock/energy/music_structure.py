"""Detection of build-ups, which rise over several beats, and drops, where the bass returns."""

from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.clock.energy.energy_frames import EnergyFeatures

SPANS: Final = (4, 8, 16)
"""Lengths over which a build-up is searched [beats]."""

RISE_DB: Final = 6.0
RISE_OCTAVES: Final = 0.7
RISE_DENSITY: Final = 1.0
"""Gain of a full build-up: loudness, brightness, onsets a second (in octaves: doubled)."""

MOST_DENSITY: Final = 0.7
"""Onset counts are unreliable: they contribute at most this ..."""

MIN_RISE: Final = 0.5
"""... and the other two must rise by this."""

MAX_STEP_SHARE: Final = 0.6
"""More than this share of a rise within one beat is a step, not a build-up."""

MIN_R_SQUARED: Final = 0.5
"""Share of the variance that the linear rise must explain (R²)."""

BUILD_THRESHOLD: Final = 0.5
"""Minimum value of a build-up that counts."""

GONE_DB: Final = 8.0
"""The bass is gone if it is this much weaker ..."""

BACK_DB: Final = 7.0
"""... and back if it is this near to its maximum."""

BASS_BELOW_MIX_DB: Final = 12.0
"""A bass this much softer than the whole is ignored: the lowest notes of a tune without bass come and go."""

BUILT_BEATS: Final = 4
"""Beats without bass that make a break after a build-up of eight beats or more ..."""

BREAK_BEATS: Final = 7
"""Beats without bass that make a break without a build-up, ..."""

GROOVE_BEATS: Final = 8
GROOVE_WITH: Final = 6
"""... if this many of the `GROOVE_BEATS` beats before had bass. Music with intermittent bass therefore has no drops. (A
piece that builds up before its first bass has a drop as well.)"""

DROP_SPACING: Final = 16
"""Minimum number of beats between drops."""

SILENT_DB: Final = -60.0
"""Level below which a beat is silent."""

NOTHING_DB: Final = -200.0
"""Bass level before the first beat."""

RESET_BEATS: Final = 16
"""Beats of silence after which a new piece begins."""

MAX_BREAK_BEATS: Final = 64
"""Maximum length of a break [beats]."""


class StructureDetector:
    """Detects build-ups and drops from the features of each beat, in order."""

    def __init__(self) -> None:
        self._beats = np.zeros((max(SPANS), 3))
        self._low = np.full(MAX_BREAK_BEATS, NOTHING_DB)
        self._count = 0
        self._bass = SILENT_DB
        self._build_countdown = 0
        self._since_drop = DROP_SPACING
        self._silent = 0
        self.build = 0.0
        """Progress of a build-up, 0 to 1."""
        self.drop = False
        """Whether the bass returned with the last beat."""

    def add(self, features: EnergyFeatures) -> None:
        """Add the features of a beat."""
        if features.loudness < SILENT_DB:
            self._silent += 1
            if self._silent >= RESET_BEATS:
                self._count, self._bass, self._build_countdown = 0, SILENT_DB, 0
            self.build, self.drop = 0.0, False
            return
        self._silent = 0
        density = np.log2(max(features.onsets, 0.5) / max(features.seconds, 0.1))
        self._beats = np.roll(self._beats, -1, axis=0)
        self._beats[-1] = features.loudness, features.octave, density
        before = self._low.copy()
        self._low = np.roll(self._low, -1)
        self._low[-1] = features.low
        self._count += 1
        self._since_drop += 1
        self.drop = features.low > features.loudness - BASS_BELOW_MIX_DB and self._drops(before, features.low)
        self._bass = max(self._bass - 0.05, features.low)
        if self.drop:
            self._since_drop = self._build_countdown = 0
            self._count = 1  # the beats before are not part of the next build-up
            self.build = 0.0
            return
        rising = [self._rising(span) for span in SPANS if self._count >= span]
        long = max(rising[1:], default=0.0)
        self.build = max(rising, default=0.0)
        self._build_countdown = 4 if long >= BUILD_THRESHOLD else max(self._build_countdown - 1, 0)

    def _drops(self, before: Float64, low: float) -> bool:
        """Whether the bass `low` [dB] returns now; `before`: levels of the beats before, oldest first."""
        there = max(self._bass - BACK_DB, SILENT_DB)
        if self._since_drop < DROP_SPACING or low < there:
            return False
        without = before < low - GONE_DB
        gone = MAX_BREAK_BEATS if without.all() else int(np.argmin(without[::-1]))
        gone = min(gone, self._count - 1)
        if gone < BUILT_BEATS:
            return False
        groove = before[-gone - GROOVE_BEATS : -gone]
        steady = int(np.count_nonzero(groove >= there)) >= GROOVE_WITH
        if self._build_countdown:
            return steady or gone >= max(self._count - 1, DROP_SPACING)
        return gone >= BREAK_BEATS and steady

    def _rising(self, span: int) -> float:
        """Return the progress of a build-up over the last `span` beats, 0 to 1."""
        beats = self._beats[-span:]
        loudness, octave, density = (beats - beats[0]).T
        heard = loudness / RISE_DB + octave / RISE_OCTAVES
        score = heard + np.clip(density / RISE_DENSITY, -MOST_DENSITY, MOST_DENSITY)
        x = np.arange(span) - 0.5 * (span - 1)
        slope = float(x @ score) / float(x @ x)
        whole = slope * (span - 1)
        least = MIN_RISE * float(x @ x) / (span - 1)
        if float(x @ heard) < least or float(x @ loudness) < 0.0 or whole <= 0.0:  # brighter and softer is a break
            return 0.0
        rest = score - score.mean() - slope * x
        spread = float(np.sum(np.square(score - score.mean())))
        straight = 1.0 - float(rest @ rest) / spread if spread > 0.0 else 0.0
        if straight < MIN_R_SQUARED or float(np.diff(score).max()) > MAX_STEP_SHARE * whole:
            return 0.0
        return min(0.5 * whole, 1.0)
