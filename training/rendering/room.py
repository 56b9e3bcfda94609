"""Rooms and loudspeakers: exponential noise after a direct sound; tilts, band limits, hum."""

import numpy as np
from scipy import signal

from training.rendering.synth import RATE, Mono


def room(rng: np.random.Generator, sound: Mono, rt60: float, drr: float) -> Mono:
    """The sound in a room: direct sound, then noise that decays by 60 dB in rt60 s; `drr`: direct to rest in dB."""
    count = int(min(rt60, 2.5) * RATE)
    times = np.arange(count) / RATE
    tail = rng.standard_normal(count) * 10 ** (-3 * times / rt60)
    delay = int(rng.uniform(0.002, 0.02) * RATE)
    tail[:delay] = 0
    cut = rng.uniform(2500, 9000)
    tail = signal.sosfilt(signal.butter(1, cut, output="sos", fs=RATE), tail)
    for _ in range(rng.integers(0, 6)):  # early reflections
        tail[int(rng.uniform(0.003, 0.04) * RATE)] += rng.uniform(-1, 1) * np.abs(tail).max() * 4
    tail *= 10 ** (-drr / 20) / (np.sqrt((tail**2).sum()) + 1e-9)
    tail[0] += 1.0
    return np.asarray(signal.oaconvolve(sound, tail.astype(np.float32))[: len(sound)], np.float32)


def tilt(rng: np.random.Generator, sound: Mono) -> Mono:
    """More or less bass and treble: shelves of up to 9 dB."""
    for corner, kind in ((rng.uniform(150, 400), "low"), (rng.uniform(2000, 6000), "high")):
        gain = 10 ** (rng.normal(0, 4) / 20)
        band = signal.sosfilt(signal.butter(1, corner, kind, output="sos", fs=RATE), sound)
        sound = np.asarray(sound + (gain - 1) * band, np.float32)
    return sound


def phone(rng: np.random.Generator, sound: Mono) -> Mono:
    """A telephone's or a small loudspeaker's band."""
    low, high = rng.uniform(90, 450), rng.uniform(2500, 9000)
    return np.asarray(signal.sosfilt(signal.butter(2, (low, high), "band", output="sos", fs=RATE), sound), np.float32)


def muffled(rng: np.random.Generator, sound: Mono) -> Mono:
    """Music from next door or under a balcony: a low pass."""
    corner = rng.uniform(250, 3000)
    return np.asarray(signal.sosfilt(signal.butter(2, corner, output="sos", fs=RATE), sound), np.float32)


def hum(rng: np.random.Generator, sound: Mono) -> Mono:
    """Mains hum with its harmonics, at 20 to 45 dB below the sound."""
    times = np.arange(len(sound)) / RATE
    base = rng.choice([50.0, 60.0])
    wave = sum(rng.uniform(0, 1) / order * np.sin(6.2832 * base * order * times) for order in (1, 2, 3, 5))
    level = np.sqrt(np.mean(sound**2)) * 10 ** (-rng.uniform(20, 45) / 20)
    return np.asarray(sound + level * wave / (np.std(wave) + 1e-9), np.float32)
