"""Energy features per beat, from audio samples and the beats detected in them."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.energy.energy_frames import AdaptiveRange, EnergyFrames
from live.clock.energy.music_structure import SILENT_DB, StructureDetector

USUAL_PERIOD: Final = 0.5
"""Assumed beat period while none is known [s]."""

SHORTEST: Final = 0.15
LONGEST: Final = 3.0
"""Bounds of beat periods [s]."""

MATCH_TOLERANCE: Final = 0.5
"""A reported beat within this share of a period of the expected one is that beat."""


@dataclass(frozen=True, slots=True)
class BeatEnergy:
    """Features of one beat; times are seconds from the first sample."""

    begin: float
    end: float
    loudness: float
    """0 to 1 in the range measured so far."""
    density: float
    """Number of onsets."""
    brightness: float
    """0 to 1."""
    low: float
    """0 to 1."""
    build: float
    """0 to 1."""
    drop: bool
    loudness_db: float


class MusicEnergy:
    """Cuts the audio at the beats. Thread: one at a time."""

    def __init__(self, sample_rate: float) -> None:
        self._frames = EnergyFrames(sample_rate)
        self._loudness = AdaptiveRange(12.0, 40.0)
        self._brightness = AdaptiveRange(1.0, 5.0, first=0.5)
        self._low = AdaptiveRange(12.0, 40.0)
        self._structure = StructureDetector()
        self._period = USUAL_PERIOD
        self._begin = 0.0
        self._next = USUAL_PERIOD

    @property
    def position(self) -> float:
        """Seconds of audio analysed."""
        return self._frames.position

    def set_beat(self, position: float, period: float) -> None:
        """Set a beat at `position` [s] (past or future) and the period [s] to the next one."""
        if not SHORTEST <= period <= LONGEST:
            return
        self._period = period
        # of all beats extrapolated from it, the one nearest to the expected one
        beats = round((self._next - position) / period)
        nearest = position + beats * period
        if abs(nearest - self._next) <= MATCH_TOLERANCE * period and nearest > self._begin + MATCH_TOLERANCE * period:
            self._next = nearest

    def feed(self, samples: npt.NDArray[np.float32]) -> list[BeatEnergy]:
        """Process samples, shape (n,); return the beats that ended with them, oldest first."""
        ended: list[BeatEnergy] = []
        start = 0
        while start < samples.shape[0]:
            start += self._frames.feed(samples, start)
            while self._frames.position >= self._next:
                ended.append(self._end_beat())
        return ended

    def _end_beat(self) -> BeatEnergy:
        heard = self._frames.pop_features()
        silent = heard.loudness < SILENT_DB
        self._structure.add(heard)
        begin, end = self._begin, self._next
        self._begin, self._next = end, end + self._period
        loudness, brightness, low = 0.0, 0.5, 0.0
        if not silent:
            loudness = self._loudness.add(heard.loudness)
            brightness = self._brightness.add(heard.octave)
            low = self._low.add(heard.low, may_lower=heard.low > SILENT_DB)
        return BeatEnergy(
            begin, end, loudness, 0.0 if silent else float(heard.onsets), brightness, low, self._structure.build,
            self._structure.drop, heard.loudness,
        )  # fmt: skip
