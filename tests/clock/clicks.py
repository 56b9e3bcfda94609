"""Seeded click tracks and noise for the tests."""

import numpy as np
import numpy.typing as npt

Sound = npt.NDArray[np.float32]


def clicks(bpm: float, sample_rate: int, seconds: float, first: float = 0.3) -> tuple[Sound, npt.NDArray[np.float64]]:
    """(samples (n,), times of the clicks [s]): bursts of 1 kHz, 30 ms long, over noise at -80 dB."""
    sound = np.random.default_rng(1).normal(0.0, 1e-4, int(seconds * sample_rate))
    times = np.arange(first, seconds - 0.1, 60.0 / bpm)
    t = np.arange(int(0.03 * sample_rate)) / sample_rate
    click = 0.8 * np.sin(2.0 * np.pi * 1000.0 * t) * np.exp(-t / 0.005)
    for time in times:
        start = round(time * sample_rate)
        sound[start : start + click.size] += click
    return sound.astype(np.float32), times


def groove(bpm: float, sample_rate: int, seconds: float) -> Sound:
    """Bass drum on the beats and loud hi-hat between them, samples (n,): misleads trackers by half a beat."""
    rng = np.random.default_rng(2)
    sound = rng.normal(0.0, 1e-4, int(seconds * sample_rate))
    t = np.arange(int(0.15 * sample_rate)) / sample_rate
    drum = 0.6 * np.sin(2.0 * np.pi * (50.0 * t + 4.0 * (1.0 - np.exp(-t / 0.03)))) * np.exp(-t / 0.06)
    hat = 0.5 * np.diff(rng.normal(0.0, 1.0, t.size + 1)) * np.exp(-t / 0.02)
    for beat in range(int((seconds - 0.5) * bpm / 60.0)):
        for offset, hit in ((0.0, drum), (0.5, hat)):
            start = round((beat + offset) * 60.0 / bpm * sample_rate)
            sound[start : start + hit.size] += hit
    return sound.astype(np.float32)
