"""Two-beat lines: where a dance whose tempo wanders begins anew every two beats, seen in how fast its feet move.

Dances of partners step quick, quick, slow: what repeats itself is not the beat but two of them. The phase of that one
component is followed through the recording, so that a line is where the dance has it, and not where one tempo for
the whole of it would. Two dancers of a pair have the same lines, each of them found without the other.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.motion.beats.dance_rhythm import blurred, rhythm_of
from live.motion.clip import Clip
from live.motion.formats.source_motion import Float64

SHORTEST: Final = 0.6
LONGEST: Final = 1.2
"""Seconds of two beats: 200 to 100 bpm."""
NEAR: Final = 0.06
"""By this share two beats may be shorter or longer than they are said to be."""
FOLLOWED: Final = 2.5
"""Standard deviation of the window in which a phase is read [s]."""
SLOW: Final = 0.5
"""Half the width of the mean [s] that is taken away first."""
FEWEST: Final = 6.0
"""So many times two beats at least."""
CLEAR: Final = 0.3
"""From this strength on the lines can be relied on: noise has 0.2, salsa 0.4 to 0.6."""
PADDED: Final = 16
"""Spectra are made of so many times the recording's length."""


@dataclass(frozen=True, slots=True, eq=False)
class TwoBeats:
    """Lines through a whole recording."""

    lines: Float64
    """When two beats begin [s], ascending, (n,): all of them."""
    strength: float
    """Amplitude of the component against that of a pure wave as strong as the whole signal, 0 to 1."""

    def beats(self, last: float) -> Float64:
        """The lines, the middles between them, and the same before the first and after the last one, from 0 to `last`
        [s]."""
        length = float(np.diff(self.lines).mean())
        lines = np.concatenate((self.lines[:1] - length, self.lines, self.lines[-1:] + length))
        beats = np.sort(np.concatenate((lines, 0.5 * (lines[1:] + lines[:-1]))))
        return np.asarray(beats[(beats >= 0.0) & (beats <= last)])


def two_beat_lines(clips: Sequence[Clip], two_beats: float | None = None) -> TwoBeats | None:
    """The lines that clips of one dance have together; None where there are too few, or nothing moves.

    All have one rate, and begin together. `two_beats` [s]: how long two beats are, as far as it is known.
    """
    rate = clips[0].sample_rate
    count = min(clip.sample_count for clip in clips)
    longest = LONGEST if two_beats is None else two_beats * (1.0 + NEAR)
    if count < FEWEST * longest * rate:
        return None
    signal = np.sum([_feet(clip, count) for clip in clips], axis=0)
    size = float(signal.std())
    if size < 1e-6:
        return None
    period = _period(signal / size, rate, two_beats)
    time = np.arange(count) / rate
    wave = signal / size * np.exp(-2j * np.pi * time / period)
    read = blurred(wave.real, FOLLOWED * rate) + 1j * blurred(wave.imag, FOLLOWED * rate)
    turns = np.maximum.accumulate(time / period + np.unwrap(np.angle(read)) / (2.0 * np.pi))
    whole = np.arange(np.ceil(turns[0]), np.floor(turns[-1]) + 1.0)
    lines = np.interp(whole, turns, time)
    strength = float(np.abs(read).mean() * np.sqrt(2.0))
    return TwoBeats(lines, strength) if len(lines) >= FEWEST - 1.0 else None


def _feet(clip: Clip, count: int) -> Float64:
    """How fast the feet are, less what changes slowly, as strong as another's, (count,)."""
    feet = rhythm_of(clip).feet[:count]
    half = max(1, round(SLOW * clip.sample_rate))
    mean = np.convolve(np.pad(feet, half, mode="edge"), np.full(2 * half + 1, 1.0 / (2 * half + 1)), mode="valid")
    return np.asarray((feet - mean) / max(float((feet - mean).std()), 1e-9))


def _period(signal: Float64, rate: float, two_beats: float | None) -> float:
    """The strongest one there is in a signal (T,) between the shortest and the longest two beats, or near those."""
    low, high = (SHORTEST, LONGEST) if two_beats is None else (two_beats / (1.0 + NEAR), two_beats * (1.0 + NEAR))
    size = PADDED * len(signal)
    strength = np.abs(np.fft.rfft(signal * np.hanning(len(signal)), size))
    hertz = np.fft.rfftfreq(size, 1.0 / rate)
    inside = np.flatnonzero((hertz >= 1.0 / high) & (hertz <= 1.0 / low))
    return float(1.0 / hertz[inside[int(np.argmax(strength[inside]))]])
