"""Energy features of an audio stream, accumulated over frames, and ranges that normalise them to 0 to 1."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.energy.energy_kernels import (
    FEATURE_COUNT,
    LOUD,
    LOW,
    MAGNITUDE,
    OCTAVES,
    POWER,
    RISE,
    append,
    spectrum_features,
)
from live.clock.energy.k_weighting import decibels, k_weight

Samples = npt.NDArray[np.float32]

WINDOW: Final = 0.0464
"""Approximate length of a frame [s]; rounded to a power of two of samples."""

HOP: Final = 0.75
"""Hop as a share of the frame length: three quarters cost a third less than the usual half."""

BANDS_HZ: Final = (30, 60, 100, 160, 250, 400, 630, 1000, 1600, 2500, 4000, 6300, 10_000, 16_000)
LOW_BANDS: Final = 2
"""Number of bass bands (to 100 Hz)."""

ONSET_RISE: Final = 1.7
"""An onset rises more than frames usually do by this factor ..."""

ONSET_MIN_RISE: Final = 0.12
"""... and at least by this [nepers, mean of the bands]."""

ONSET_SPACING: Final = 1
"""Minimum number of frames between onsets (70 ms)."""

USUAL_RISE_WEIGHT: Final = 0.03
"""Weight of each frame in the usual rise (time constant about 1.2 s)."""


ONSET_FLOOR: Final = 0.01
"""A band with less than this share of the usual power per bin (-20 dB) gives no onsets."""


@dataclass(frozen=True, slots=True)
class EnergyFeatures:
    """Mean features of a stretch of music."""

    seconds: float
    loudness: float
    """K-weighted [dB]."""
    low: float
    """Loudness of the bass [dB]."""
    octave: float
    """Spectral centroid in octaves above 1 kHz; meaningless in silence."""
    onsets: int
    """Number of onsets."""


class EnergyFrames:
    """Cuts blocks of any length into frames; allocates no audio-sized arrays after its creation."""

    def __init__(self, sample_rate: float) -> None:
        self.sample_rate = sample_rate
        size = 1 << round(math.log2(sample_rate * WINDOW))
        self.hop = int(HOP * size)
        """Hop size in samples."""
        self._kept = size - self.hop
        self._history = np.zeros(size, np.float32)
        self._filled = 0
        self._frames = 0
        self._window = _window(size, self._kept)
        self._windowed = np.zeros(size, np.float32)
        self._spectrum = np.zeros(size // 2 + 1, np.complex64)
        frequency = np.arange(size // 2 + 1) * sample_rate / size
        scale = 2.0 / (size * float(np.sum(np.square(self._window, dtype=np.float64))))
        self._weight = (scale * k_weight(frequency)).astype(np.float32)
        self._octave = np.log2(np.maximum(frequency, 1.0) / 1000.0).astype(np.float32)
        edges = np.searchsorted(frequency, [edge for edge in BANDS_HZ if edge <= 0.5 * sample_rate])
        self._edges = edges.astype(np.int32)
        self._levels = np.full(len(edges) - 1, math.log(1e-9) / 2.0, np.float32)
        self._out = np.zeros(FEATURE_COUNT)
        self._sum = np.zeros(FEATURE_COUNT)
        self._count = 0
        self._onsets = 0
        self._usual = ONSET_MIN_RISE
        self._power = 0.0
        self._since_onset = ONSET_SPACING
        self._last_features = EnergyFeatures(0.0, decibels(0.0), decibels(0.0), 0.0, 0)

    @property
    def position(self) -> float:
        """Seconds of sound in the frames read so far."""
        return self._frames * self.hop / self.sample_rate

    def feed(self, samples: Samples, start: int) -> int:
        """Take samples[start:], shape (n,), up to the end of the frame, and analyse a full frame; return the number
        taken."""
        taken: int = min(self.hop - self._filled, samples.shape[0] - start)
        append(self._history, self._kept + self._filled, samples, start, taken)
        self._filled += taken
        if self._filled == self.hop:
            self._analyse()
            self._filled = 0
            self._frames += 1
        return taken

    def pop_features(self) -> EnergyFeatures:
        """Return the features since the last call; if no frame was completed, those of the last call."""
        if not self._count:
            return self._last_features
        total, count = self._sum, self._count
        octave = total[OCTAVES] / total[MAGNITUDE] if total[MAGNITUDE] > 0.0 else 0.0
        self._last_features = EnergyFeatures(
            count * self.hop / self.sample_rate,
            decibels(total[LOUD] / count),
            decibels(total[LOW] / count),
            float(octave),
            self._onsets,
        )
        self._sum[:] = 0.0
        self._count = self._onsets = 0
        return self._last_features

    def _analyse(self) -> None:
        np.multiply(self._history, self._window, out=self._windowed)
        np.fft.rfft(self._windowed, out=self._spectrum)  # type: ignore[arg-type] # its stub knows no complex64
        self._history[: self._kept] = self._history[self.hop :]
        floor = ONSET_FLOOR * self._power
        spectrum_features(
            self._spectrum, self._weight, self._octave, self._edges, LOW_BANDS, floor, self._levels, self._out
        )
        self._power += USUAL_RISE_WEIGHT * (float(self._out[POWER]) - self._power)
        self._sum += self._out
        self._count += 1
        self._detect_onset(float(self._out[RISE]))

    def _detect_onset(self, rise: float) -> None:
        self._since_onset += 1
        if rise > max(ONSET_RISE * self._usual, ONSET_MIN_RISE) and self._since_onset > ONSET_SPACING:
            self._onsets += 1
            self._since_onset = 0
        self._usual += USUAL_RISE_WEIGHT * (min(rise, 4.0 * self._usual + ONSET_MIN_RISE) - self._usual)


def _window(size: int, shared: int) -> Samples:
    """Return a window whose squares add up to 1 where frames overlap, so that all moments have equal weight."""
    window = np.ones(size, np.float32)
    slope = np.sin(0.5 * np.pi * (np.arange(shared) + 0.5) / shared)
    window[:shared], window[-shared:] = slope, slope[::-1]
    return window


NARROWING: Final = 0.003
"""Share by which the range narrows with each value."""

END_STEP: Final = 0.5
"""Share of the distance that an end moves to a value outside, so that single values count for less."""


class AdaptiveRange:
    """An adaptive range that widens at once and narrows slowly; it maps values to 0 to 1."""

    def __init__(self, narrowest: float, widest: float, *, first: float = 1.0) -> None:
        """`narrowest`, `widest`: limits of the range. `first`: position of the first value in it, 0 to 1."""
        self._narrowest, self._widest, self._first = narrowest, widest, first
        self.low = self.high = 0.0
        """The ends."""
        self._known = False

    def add(self, value: float, *, may_lower: bool = True) -> float:
        """Widen the range to a value and return its position, 0 to 1. `may_lower`: whether it may lower the range.

        Pauses must not lower it, as they are no quiet music.
        """
        if not self._known:
            self._known = True
            self.low = value - self._first * self._narrowest
            self.high = self.low + self._narrowest
        middle, half = 0.5 * (self.low + self.high), 0.5 * (self.high - self.low) * (1.0 - NARROWING)
        self.low, self.high = middle - half, middle + half
        if value > self.high:
            self.high += END_STEP * (value - self.high)
        elif value < self.low and may_lower:
            self.low += END_STEP * (value - self.low)
        if self.high - self.low < self._narrowest:
            grow = 0.5 * (self._narrowest - (self.high - self.low))
            self.low, self.high = self.low - grow, self.high + grow
        self.low = max(self.low, self.high - self._widest)
        return min(max((value - self.low) / (self.high - self.low), 0.0), 1.0)
