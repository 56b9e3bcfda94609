"""MusicEnergy: samples and the beats found in them in; what each beat was like out."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.energy.energy_frames import EnergyFrames, Range
from live.clock.energy.music_structure import SILENT_DB, Structure

USUAL_PERIOD: Final = 0.5
"""Seconds that count as a beat while none is known."""

SHORTEST: Final = 0.15
LONGEST: Final = 3.0
"""Seconds of a beat."""

NEAR: Final = 0.5
"""A beat that is named within this share of a period of the one expected is that one."""


@dataclass(frozen=True, slots=True)
class BeatEnergy:
    """What one beat was like; times are seconds from the first sample."""

    begin: float
    end: float
    loudness: float
    """0 to 1 in the range heard so far."""
    density: float
    """Onsets in it."""
    brightness: float
    """0 to 1."""
    low: float
    """0 to 1."""
    build: float
    """0 to 1."""
    drop: bool
    loudness_db: float


class MusicEnergy:
    """Cuts the sound at the beats. Thread: one at a time."""

    def __init__(self, sample_rate: float) -> None:
        self._frames = EnergyFrames(sample_rate)
        self._loudness = Range(12.0, 40.0)
        self._brightness = Range(1.0, 5.0, first=0.5)
        self._low = Range(12.0, 40.0)
        self._structure = Structure()
        self._period = USUAL_PERIOD
        self._begin = 0.0
        self._next = USUAL_PERIOD

    @property
    def position(self) -> float:
        """Seconds of sound heard."""
        return self._frames.position

    def beat(self, position: float, period: float) -> None:
        """A beat lies, or will lie, at `position` [s], and the next one `period` [s] later."""
        if not SHORTEST <= period <= LONGEST:
            return
        self._period = period
        # of all beats that follow from it, the one nearest to what is expected
        beats = round((self._next - position) / period)
        nearest = position + beats * period
        if abs(nearest - self._next) <= NEAR * period and nearest > self._begin + NEAR * period:
            self._next = nearest

    def feed(self, samples: npt.NDArray[np.float32]) -> list[BeatEnergy]:
        """Take samples, shape (n,); the beats that ended with them, oldest first."""
        ended: list[BeatEnergy] = []
        start = 0
        while start < samples.shape[0]:
            start += self._frames.take(samples, start)
            while self._frames.position >= self._next:
                ended.append(self._end())
        return ended

    def _end(self) -> BeatEnergy:
        heard = self._frames.cut()
        silent = heard.loudness < SILENT_DB
        self._structure.add(heard)
        begin, end = self._begin, self._next
        self._begin, self._next = end, end + self._period
        loudness, brightness, low = 0.0, 0.5, 0.0
        if not silent:
            loudness = self._loudness.add(heard.loudness)
            brightness = self._brightness.add(heard.octave)
            low = self._low.add(heard.low, lowest=heard.low > SILENT_DB)
        return BeatEnergy(
            begin, end, loudness, 0.0 if silent else float(heard.onsets), brightness, low, self._structure.build,
            self._structure.drop, heard.loudness,
        )  # fmt: skip
