"""EnergyFrames: a stream of samples, cut into frames, and what they come to until somebody asks.

Range: where a value lies among those that this room has shown so far.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.energy.energy_kernels import LOUD, LOW, MAGNITUDE, OCTAVES, OUT, POWER, RISE, append, describe
from live.clock.energy.k_weighting import decibels, k_weight

Samples = npt.NDArray[np.float32]

WINDOW: Final = 0.0464
"""Wanted length of a frame [s]; it is the power of two of samples that comes nearest."""

HOP: Final = 0.75
"""A frame begins after so much of the one before: three quarters cost a third less than the usual half."""

BANDS_HZ: Final = (30, 60, 100, 160, 250, 400, 630, 1000, 1600, 2500, 4000, 6300, 10_000, 16_000)
LOW_BANDS: Final = 2
"""The first bands, to 100 Hz, are the bass."""

ONSET_RISE: Final = 1.7
"""An onset rises so many times more than frames usually do ..."""

ONSET_LEAST: Final = 0.12
"""... and by this at least [nepers, mean of the bands]."""

ONSET_APART: Final = 1
"""Frames between onsets at least (70 ms)."""

USUAL: Final = 0.03
"""Share of each frame in the usual rise (time constant about 1.2 s)."""


UNHEARD: Final = 0.01
"""A band with less than this share of the usual power per bin (-20 dB) makes no onsets."""


@dataclass(frozen=True, slots=True)
class Heard:
    """What a stretch of music was like."""

    seconds: float
    loudness: float
    """K-weighted [dB]."""
    low: float
    """Loudness of the bass [dB]."""
    octave: float
    """Where the spectrum's centre lies, octaves over 1 kHz; meaningless in silence."""
    onsets: int
    """How often something began."""


class EnergyFrames:
    """Feeds blocks of any length; nothing of sound's size is allocated after it was made."""

    def __init__(self, sample_rate: float) -> None:
        self.sample_rate = sample_rate
        size = 1 << round(math.log2(sample_rate * WINDOW))
        self.hop = int(HOP * size)
        """Samples from frame to frame."""
        self._kept = size - self.hop
        self._history = np.zeros(size, np.float32)
        self._filled = 0
        self._frames = 0
        self._window = _window(size, self._kept)
        self._cut = np.zeros(size, np.float32)
        self._spectrum = np.zeros(size // 2 + 1, np.complex64)
        frequency = np.arange(size // 2 + 1) * sample_rate / size
        scale = 2.0 / (size * float(np.sum(np.square(self._window, dtype=np.float64))))
        self._weight = (scale * k_weight(frequency)).astype(np.float32)
        self._octave = np.log2(np.maximum(frequency, 1.0) / 1000.0).astype(np.float32)
        edges = np.searchsorted(frequency, [edge for edge in BANDS_HZ if edge <= 0.5 * sample_rate])
        self._edges = edges.astype(np.int32)
        self._levels = np.full(len(edges) - 1, math.log(1e-9) / 2.0, np.float32)
        self._out = np.zeros(OUT)
        self._sum = np.zeros(OUT)
        self._count = 0
        self._onsets = 0
        self._usual = ONSET_LEAST
        self._power = 0.0
        self._since_onset = ONSET_APART
        self._heard = Heard(0.0, decibels(0.0), decibels(0.0), 0.0, 0)

    @property
    def position(self) -> float:
        """Seconds of sound in the frames read so far."""
        return self._frames * self.hop / self.sample_rate

    def take(self, samples: Samples, start: int) -> int:
        """Take samples[start:], shape (n,), up to the end of the frame, which then is read; returns how many."""
        taken: int = min(self.hop - self._filled, samples.shape[0] - start)
        append(self._history, self._kept + self._filled, samples, start, taken)
        self._filled += taken
        if self._filled == self.hop:
            self._read()
            self._filled = 0
            self._frames += 1
        return taken

    def cut(self) -> Heard:
        """What was heard since the last call; of less than a frame, what was heard before."""
        if not self._count:
            return self._heard
        total, count = self._sum, self._count
        octave = total[OCTAVES] / total[MAGNITUDE] if total[MAGNITUDE] > 0.0 else 0.0
        self._heard = Heard(
            count * self.hop / self.sample_rate,
            decibels(total[LOUD] / count),
            decibels(total[LOW] / count),
            float(octave),
            self._onsets,
        )
        self._sum[:] = 0.0
        self._count = self._onsets = 0
        return self._heard

    def _read(self) -> None:
        np.multiply(self._history, self._window, out=self._cut)
        np.fft.rfft(self._cut, out=self._spectrum)  # type: ignore[arg-type] # its stub knows no complex64
        self._history[: self._kept] = self._history[self.hop :]
        floor = UNHEARD * self._power
        describe(self._spectrum, self._weight, self._octave, self._edges, LOW_BANDS, floor, self._levels, self._out)
        self._power += USUAL * (float(self._out[POWER]) - self._power)
        self._sum += self._out
        self._count += 1
        self._look_for_onset(float(self._out[RISE]))

    def _look_for_onset(self, rise: float) -> None:
        self._since_onset += 1
        if rise > max(ONSET_RISE * self._usual, ONSET_LEAST) and self._since_onset > ONSET_APART:
            self._onsets += 1
            self._since_onset = 0
        self._usual += USUAL * (min(rise, 4.0 * self._usual + ONSET_LEAST) - self._usual)


def _window(size: int, shared: int) -> Samples:
    """A window whose squares add up to 1 where frames share samples, so that no moment counts more than another."""
    window = np.ones(size, np.float32)
    slope = np.sin(0.5 * np.pi * (np.arange(shared) + 0.5) / shared)
    window[:shared], window[-shared:] = slope, slope[::-1]
    return window


FORGET: Final = 0.003
"""Share by which the ends come together with each value."""

RISES: Final = 0.5
"""Share of the way that an end goes with a value beyond it, so that single values count for less."""


class Range:
    """A lowest and a highest value that widen at once and narrow slowly; values come as 0 to 1 between them."""

    def __init__(self, narrowest: float, widest: float, *, first: float = 1.0) -> None:
        """`narrowest`, `widest`: of the range. `first`: where in it the first value lies, 0 to 1."""
        self._narrowest, self._widest, self._first = narrowest, widest, first
        self.low = self.high = 0.0
        """The ends."""
        self._known = False

    def add(self, value: float, *, lowest: bool = True) -> float:
        """Widen the range to a value, and say where it lies, 0 to 1. `lowest`: whether it may lower the range.

        So that pauses, which are no quiet music, do not.
        """
        if not self._known:
            self._known = True
            self.low = value - self._first * self._narrowest
            self.high = self.low + self._narrowest
        middle, half = 0.5 * (self.low + self.high), 0.5 * (self.high - self.low) * (1.0 - FORGET)
        self.low, self.high = middle - half, middle + half
        if value > self.high:
            self.high += RISES * (value - self.high)
        elif value < self.low and lowest:
            self.low += RISES * (value - self.low)
        if self.high - self.low < self._narrowest:
            grow = 0.5 * (self._narrowest - (self.high - self.low))
            self.low, self.high = self.low - grow, self.high + grow
        self.low = max(self.low, self.high - self._widest)
        return min(max((value - self.low) / (self.high - self.low), 0.0), 1.0)
