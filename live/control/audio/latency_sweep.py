"""Measurement of the audio round-trip latency from an output to an input with sine sweeps."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32, Float64
from live.base.errors import PersonError
from live.clock.sample_clock import SampleClock
from live.clock.time_source import Clock
from live.control.audio.channel_mixer import ChannelMixer, Channels
from live.control.audio.device_stream import BLOCK
from live.control.audio.devices import SoundDevice, close_stream, open_stream

SWEEP_SECONDS: Final = 0.08
SWEEP_HZ: Final = (600.0, 6_000.0)
"""Loudspeakers and microphones of any size cover this band; a hall's noise lies below it."""

LEVEL: Final = 0.5
LEAD_IN: Final = 2.0
"""Seconds of silence before the first sweep, until sound servers have filled their buffers and the sample lines settle.
"""

PAUSE_RANGE: Final = (0.55, 0.85)
"""Seconds between sweeps, drawn at random, so that a delay longer than one pause is not ambiguous."""

EARLIEST: Final = -0.05
LATEST: Final = 1.5
"""Range of delays searched [s]; it starts below 0 because no latency is known yet."""

NEAR: Final = 0.030
"""Range around the common delay in which each sweep is searched [s]."""

MIN_PEAK_RATIO: Final = 6.0
"""Minimum ratio of a sweep's peak to the median around it."""

SPREAD_MAX: Final = 0.010
"""Maximum spread of the sweeps [s] (interquartile range)."""


@dataclass(frozen=True, slots=True, eq=False)
class SweepTrain:
    """Sweeps to play, starting at `times` [s] in `sound`, shape (n,), at `sample_rate` [Hz]."""

    sound: Float32
    times: Float64
    sample_rate: float


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """Recording made while a train was played. Stamps are (frames handed over, time [s]) in order."""

    sound: Float32
    """Mono, shape (n,)."""
    sample_rate: float
    input_stamps: list[tuple[int, float]]
    """Stamps of the recorded frames."""
    output_stamps: list[tuple[int, float]]
    """Stamps of the train's frames handed to the output."""


@dataclass(frozen=True, slots=True)
class RoundTrip:
    """Delay from handing a sample to the output until it arrives at the input [s]."""

    seconds: float
    """Median of all sweeps."""
    spread: float
    """Interquartile range of the sweeps [s]."""
    detected: int
    """Number of sweeps clearly detected …"""
    total: int
    """… of this number."""


def sweep(sample_rate: float) -> Float64:
    """Return the sweep, shape (n,), with a Hann window."""
    t = np.arange(round(SWEEP_SECONDS * sample_rate)) / sample_rate
    low, high = SWEEP_HZ
    phase = 2.0 * np.pi * (low * t + 0.5 * (high - low) * t * t / SWEEP_SECONDS)
    return np.asarray(np.hanning(t.size) * np.sin(phase))


def sweep_train(sample_rate: float, repeats: int, seed: int = 1) -> SweepTrain:
    """Return `repeats` sweeps with random pauses from `seed`, and silence before and after."""
    pauses = np.random.default_rng(seed).uniform(*PAUSE_RANGE, repeats)
    times = LEAD_IN + np.concatenate([[0.0], np.cumsum(pauses[:-1])])
    sound = np.zeros(int((times[-1] + LATEST + 0.5) * sample_rate), np.float32)
    one = LEVEL * sweep(sample_rate)
    starts = np.round(times * sample_rate).astype(np.int64)
    for start in starts:
        sound[start : start + one.size] += one
    return SweepTrain(sound, starts / sample_rate, sample_rate)


def measure(train: SweepTrain, recording: Recording) -> RoundTrip:
    """Return the round trip; PersonError with a remedy if the sweeps were not detected, or differ too much."""
    rate = recording.sample_rate
    begun = _times(recording.output_stamps, train.times * train.sample_rate, train.sample_rate)
    level = float(np.nanmax(np.abs(recording.sound), initial=0.0)) if recording.sound.size else 0.0
    if level < 1e-5:
        raise PersonError(
            "the recording is silent", "plug the input in, unmute it, and choose its channel with --audio-channel"
        )
    size = int((LATEST - EARLIEST) * rate)
    where = _frames(recording.input_stamps, begun + EARLIEST, rate)
    peaks = _matches(recording.sound, where, size, rate)
    common = int(np.argmax(np.sum(peaks / np.median(peaks, axis=1, keepdims=True), axis=0)))
    near = slice(max(common - int(NEAR * rate), 0), common + int(NEAR * rate) + 1)
    delays = []
    for row, begin in zip(peaks, where, strict=True):
        best = near.start + int(np.argmax(row[near]))
        if row[best] > MIN_PEAK_RATIO * float(np.median(row)):
            delays.append(EARLIEST + (_interpolated_peak(row, best) + np.ceil(begin) - begin) / rate)
    if len(delays) < max(3, len(begun) // 2):
        raise PersonError(
            f"only {len(delays)} of {len(begun)} sweeps were heard",
            "turn the loudspeakers up, bring the microphone nearer, and keep the hall quiet",
        )
    low, median, high = np.quantile(delays, [0.25, 0.5, 0.75])
    if high - low > SPREAD_MAX:
        raise PersonError(
            f"the sweeps were heard {1000 * (high - low):.0f} ms apart: no delay can be measured",
            "end other programs that use the sound or the processor, and measure again",
        )
    return RoundTrip(float(median), float(high - low), len(delays), len(begun))


def _times(stamps: list[tuple[int, float]], frames: Float64, rate: float) -> Float64:
    """Return the times at which `frames` were handed over, by the line as fitted one second later, as in a show."""
    line, times, at = SampleClock(rate), np.zeros(len(frames)), 0
    for index, frame in enumerate(frames):
        while at < len(stamps) and stamps[at][0] < frame + rate:
            line.observe(*stamps[at])
            at += 1
        times[index] = line.time_of(frame)
    return times


def _frames(stamps: list[tuple[int, float]], times: Float64, rate: float) -> Float64:
    """Return the frame that arrived at each of `times`."""
    line, frames, at = SampleClock(rate), np.zeros(len(times)), 0
    for index, moment in enumerate(times):
        while at < len(stamps) and stamps[at][1] < moment + 1.0:
            line.observe(*stamps[at])
            at += 1
        frames[index] = line.frame_at(moment)
    return frames


def _matches(sound: Float32, where: Float64, size: int, rate: float) -> Float64:
    """Return the match of the sweep for `size` delays in samples after each frame of `where`, (sweeps, size).

    It is the magnitude of the analytic correlation, so reversed polarity or a filter's phase moves no peak.
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


def _interpolated_peak(row: Float64, peak: int) -> float:
    """Return a peak's position between samples, from a parabola through it and its neighbours."""
    if not 0 < peak < len(row) - 1:
        return float(peak)
    before, at, after = row[peak - 1 : peak + 2]
    bend = before - 2.0 * at + after
    return peak + (0.0 if bend == 0.0 else float(0.5 * (before - after) / bend))


START_TIMEOUT: Final = 5.0
"""Maximum seconds until devices start."""

Stamps = list[tuple[int, float]]


class Microphone:
    """Records an input from opening to closing, for at most `seconds`."""

    def __init__(self, device: SoundDevice, channels: Channels, seconds: float, clock: Clock) -> None:
        """Open the input; PersonError if it refuses or lacks the channels."""
        missing = channels.missing(device.channels)
        if missing:
            raise PersonError(f"{device.name}: {missing}", "choose others with --audio-channel, see `live devices`")
        chosen = channels.select(device.channels)
        self._chosen = chosen
        self._sound = np.zeros((int(seconds * device.sample_rate), len(chosen)), np.float32)
        self._count = 0
        self.stamps: Stamps = []
        self.sample_rate = device.sample_rate

        def heard(block: npt.NDArray[np.float32], _frames: int, _times: Any, _status: Any) -> None:
            now = clock.now()
            fitting = block[: len(self._sound) - self._count, list(chosen)]
            self._sound[self._count : self._count + len(fitting)] = fitting
            self._count += len(fitting)
            self.stamps.append((self._count, now))

        self._stream = _open(
            "input",
            device,
            channels=max(chosen) + 1,
            samplerate=device.sample_rate,
            blocksize=BLOCK,
            latency="low",
            callback=heard,
        )
        self.latency = _reported_latency(self._stream)

    def close(self) -> None:
        """Stop recording."""
        close_stream(self._stream)

    @property
    def full(self) -> bool:
        """Whether the recording is full."""
        return self._count >= len(self._sound)

    def sound(self) -> npt.NDArray[np.float32]:
        """Return the recording so far as mono, shape (n,)."""
        mixer = ChannelMixer(range(len(self._chosen)), self.sample_rate, BLOCK)
        blocks = [self._sound[at : min(at + BLOCK, self._count)] for at in range(0, self._count, BLOCK)]
        return np.concatenate([mixer.mix(block).copy() for block in blocks] or [np.zeros(0, np.float32)])

    def time_of(self, seconds: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Return the times at which these positions of the sound arrived [s of the clock]."""
        line, at, times = SampleClock(self.sample_rate), 0, np.zeros(len(seconds))
        for index, frame in enumerate(seconds * self.sample_rate):
            while at < len(self.stamps) and self.stamps[at][0] < frame + self.sample_rate:
                line.observe(*self.stamps[at])
                at += 1
            times[index] = line.time_of(frame)
        return times


def play_and_record(
    train: SweepTrain,
    output: SoundDevice,
    microphone: Microphone,
    clock: Clock,
    wait: Callable[[float], None] = time.sleep,
) -> tuple[Recording, float | None]:
    """Play the train and record it; return also the output's reported latency [s], None if it is implausible.

    PersonError if the output refuses, or a device delivers nothing.
    """
    played: Stamps = []
    at = 0

    def callback(out: npt.NDArray[np.float32], frames: int, _times: Any, _status: Any) -> None:
        nonlocal at
        played.append((at, clock.now()))
        block = train.sound[at : at + frames]
        out[: len(block)] = block[:, None]
        out[len(block) :] = 0.0
        at += frames

    stream = _open(
        "output",
        output,
        channels=min(output.channels, 2),
        samplerate=train.sample_rate,
        latency="high",
        callback=callback,
    )
    try:
        latency = _reported_latency(stream)
        deadline = clock.now() + START_TIMEOUT + len(train.sound) / train.sample_rate
        while at < len(train.sound) and not microphone.full:
            if clock.now() > deadline:
                raise PersonError(
                    f"{output.name} plays nothing" if at < len(train.sound) else "no sound arrives",
                    "see `live devices`; name others with --output and --audio",
                )
            wait(0.05)
    finally:
        close_stream(stream)
    return Recording(microphone.sound(), microphone.sample_rate, microphone.stamps, played), latency


def _open(kind: str, device: SoundDevice, **options: Any) -> Any:
    try:
        return open_stream(kind, device=device.index, dtype="float32", **options)
    except Exception as error:  # PortAudioError, whose class exists only with PortAudio
        raise PersonError(f"the sound {kind} {device.name!r} refuses: {error}", "see `live devices`") from None


def _reported_latency(stream: Any) -> float | None:
    """Return a device's reported latency [s]; None if it is implausible."""
    latency = float(stream.latency)
    return latency if 0.0 < latency < 1.0 else None
