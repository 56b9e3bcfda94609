"""Calibration: how long sound takes from an output to an input, from sweeps that are played and heard again."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError
from live.clock.sample_clock import SampleClock

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]

SWEEP_SECONDS: Final = 0.08
SWEEP_HZ: Final = (600.0, 6_000.0)
"""Loudspeakers and microphones of any size hear this, and noise of a hall lies below."""

LEVEL: Final = 0.5
FIRST: Final = 2.0
"""Seconds of silence before the first sweep: sound servers fill their buffers, and the lines settle."""

APART: Final = (0.55, 0.85)
"""Seconds between sweeps, drawn at random: a delay longer than one pause is told from a short one."""

EARLIEST: Final = -0.05
LATEST: Final = 1.5
"""Delays that are looked for [s]; below 0 too, because nothing is known yet."""

NEAR: Final = 0.030
"""Seconds around the common delay in which each sweep is looked for."""

CLEAR: Final = 6.0
"""How far a sweep's peak must stand above the median of what is around it."""

SPREAD_MAX: Final = 0.010
"""Seconds by which the sweeps may differ (interquartile range)."""


@dataclass(frozen=True, slots=True, eq=False)
class Train:
    """Sweeps to be played: `times` [s] of their beginnings in `sound`, shape (n,), at `sample_rate` [Hz]."""

    sound: Float32
    times: Float64
    sample_rate: float


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """What was heard while a train was played. Stamps are (frames handed over by then, time [s]) in order."""

    sound: Float32
    """One channel, shape (n,)."""
    sample_rate: float
    heard: list[tuple[int, float]]
    """When how much of it was there."""
    played: list[tuple[int, float]]
    """When how much of the train had been handed to the output."""


@dataclass(frozen=True, slots=True)
class RoundTrip:
    """Seconds from a sample handed to the output until it was there at the input."""

    seconds: float
    """Median of all sweeps."""
    spread: float
    """Half of the sweeps lie within this of each other [s]."""
    heard: int
    """Sweeps that were heard clearly ..."""
    of: int
    """... of so many."""


def sweep(sample_rate: float) -> Float64:
    """The sound that is played, shape (n,): a sweep, louder and softer with a Hann window."""
    t = np.arange(round(SWEEP_SECONDS * sample_rate)) / sample_rate
    low, high = SWEEP_HZ
    phase = 2.0 * np.pi * (low * t + 0.5 * (high - low) * t * t / SWEEP_SECONDS)
    return np.asarray(np.hanning(t.size) * np.sin(phase))


def sweep_train(sample_rate: float, repeats: int, seed: int = 1) -> Train:
    """`repeats` sweeps with pauses drawn from `seed`, silence before and after."""
    pauses = np.random.default_rng(seed).uniform(*APART, repeats)
    times = FIRST + np.concatenate([[0.0], np.cumsum(pauses[:-1])])
    sound = np.zeros(int((times[-1] + LATEST + 0.5) * sample_rate), np.float32)
    one = LEVEL * sweep(sample_rate)
    starts = np.round(times * sample_rate).astype(np.int64)
    for start in starts:
        sound[start : start + one.size] += one
    return Train(sound, starts / sample_rate, sample_rate)


def measure(train: Train, recording: Recording) -> RoundTrip:
    """The round trip; PersonError with a remedy if the sweeps were not heard, or differ too much."""
    rate = recording.sample_rate
    begun = _times(recording.played, train.times * train.sample_rate, train.sample_rate)
    level = float(np.nanmax(np.abs(recording.sound), initial=0.0)) if recording.sound.size else 0.0
    if level < 1e-5:
        raise PersonError(
            "nothing at all was heard", "plug the input in, unmute it, and choose its channel with --audio-channel"
        )
    size = int((LATEST - EARLIEST) * rate)
    where = _frames(recording.heard, begun + EARLIEST, rate)
    peaks = _matches(recording.sound, where, size, rate)
    common = int(np.argmax(np.sum(peaks / np.median(peaks, axis=1, keepdims=True), axis=0)))
    near = slice(max(common - int(NEAR * rate), 0), common + int(NEAR * rate) + 1)
    delays = []
    for row, begin in zip(peaks, where, strict=True):
        best = near.start + int(np.argmax(row[near]))
        if row[best] > CLEAR * float(np.median(row)):
            delays.append(EARLIEST + (_between(row, best) + np.ceil(begin) - begin) / rate)
    if len(delays) < max(3, len(begun) // 2):
        raise PersonError(
            f"only {len(delays)} of {len(begun)} sweeps were heard",
            "turn the loudspeakers up, bring the microphone nearer, and have it quiet meanwhile",
        )
    low, median, high = np.quantile(delays, [0.25, 0.5, 0.75])
    if high - low > SPREAD_MAX:
        raise PersonError(
            f"the sweeps were heard {1000 * (high - low):.0f} ms apart: no delay can be told from that",
            "end other programs that use the sound or the processor, and measure again",
        )
    return RoundTrip(float(median), float(high - low), len(delays), len(begun))


def _times(stamps: list[tuple[int, float]], frames: Float64, rate: float) -> Float64:
    """When each of `frames` was handed over: by the line as it lay a second later, as a show would say then."""
    line, times, at = SampleClock(rate), np.zeros(len(frames)), 0
    for index, frame in enumerate(frames):
        while at < len(stamps) and stamps[at][0] < frame + rate:
            line.observe(*stamps[at])
            at += 1
        times[index] = line.time_of(frame)
    return times


def _frames(stamps: list[tuple[int, float]], times: Float64, rate: float) -> Float64:
    """Which frame was there at each of `times`."""
    line, frames, at = SampleClock(rate), np.zeros(len(times)), 0
    for index, time in enumerate(times):
        while at < len(stamps) and stamps[at][1] < time + 1.0:
            line.observe(*stamps[at])
            at += 1
        frames[index] = line.frame_at(time)
    return frames


def _matches(sound: Float32, where: Float64, size: int, rate: float) -> Float64:
    """How well a sweep fits, for each of `size` delays in samples after each frame of `where`, (sweeps, size).

    The magnitude of the analytic correlation: a reversed polarity, or a filter's phase, moves no peak.
    """
    one = sweep(rate)
    length = 1 << int(np.ceil(np.log2(size + 2 * one.size)))
    spectrum = np.conj(np.fft.fft(one, length))
    analytic = np.zeros(length)
    analytic[0], analytic[1 : length // 2] = 1.0, 2.0
    clean = np.nan_to_num(sound.astype(np.float64), nan=0.0, posinf=0.0, neginf=0.0)
    found = np.full((len(where), size), 1e-12)
    for row, begin in enumerate(where):
        start = int(np.ceil(begin))
        piece = clean[max(start, 0) : max(start + size + one.size, 0)]
        padded = np.concatenate([np.zeros(max(-start, 0)), piece])[: size + one.size]
        found[row] += np.abs(np.fft.ifft(np.fft.fft(padded, length) * spectrum * analytic))[:size]
    return found


def _between(row: Float64, peak: int) -> float:
    """The place of a peak between samples: the top of a parabola through it and its neighbours."""
    if not 0 < peak < len(row) - 1:
        return float(peak)
    before, at, after = row[peak - 1 : peak + 2]
    bend = before - 2.0 * at + after
    return peak + (0.0 if bend == 0.0 else float(0.5 * (before - after) / bend))
