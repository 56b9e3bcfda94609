"""Levels: compression, limiting, clipping, fades, and the level of the whole."""

import numpy as np
from scipy import signal

from training.rendering.synth import RATE, Mono


def compress(rng: np.random.Generator, sound: Mono) -> Mono:
    """A compressor: what is loud is turned down, with pumping where its release is slow."""
    attack, release = rng.uniform(0.003, 0.02), rng.uniform(0.05, 0.4)
    step = 64
    frames = np.sqrt(np.mean(sound[: len(sound) // step * step].reshape(-1, step) ** 2, axis=1))
    smooth = np.empty_like(frames)
    level = 0.0
    up, down = 1 - np.exp(-step / RATE / attack), 1 - np.exp(-step / RATE / release)
    for index, value in enumerate(frames.tolist()):
        level += (up if value > level else down) * (value - level)
        smooth[index] = level
    threshold = np.quantile(smooth, rng.uniform(0.2, 0.7)) + 1e-6
    ratio = rng.uniform(2, 8)
    gain = np.minimum(1.0, (smooth / threshold + 1e-9) ** (1 / ratio - 1))
    return np.asarray(sound * np.interp(np.arange(len(sound)) / step, np.arange(len(gain)), gain), np.float32)


def limit(rng: np.random.Generator, sound: Mono) -> Mono:
    """Driven into soft saturation by up to 18 dB."""
    sound = normal(sound, 1.0)
    return np.asarray(np.tanh(sound * 10 ** (rng.uniform(0, 18) / 20)), np.float32)


def clip(rng: np.random.Generator, sound: Mono) -> Mono:
    """An input turned up too far: hard clipping by 3 to 18 dB."""
    return np.asarray(np.clip(normal(sound, 10 ** (rng.uniform(3, 18) / 20)), -1, 1), np.float32)


def sampler(rng: np.random.Generator, sound: Mono) -> Mono:
    """An old sampler: few bits, a low rate, driven a little."""
    hold = int(rng.integers(2, 5))
    bits = 2.0 ** rng.integers(6, 12)
    held = np.repeat(normal(sound, 1.0)[::hold], hold)[: len(sound)]
    return np.asarray(np.round(np.tanh(held * rng.uniform(1, 2.5)) * bits) / bits, np.float32)


def normal(sound: Mono, peak: float) -> Mono:
    """With this peak."""
    return np.asarray(sound * (peak / (np.abs(sound).max() + 1e-6)), np.float32)


def fade(sound: Mono, start: float, end: float) -> Mono:
    """Faded along seconds from start to end: out where end is later, in (from silence) where it is earlier."""
    times = np.arange(len(sound)) / RATE
    if end > start:
        curve = np.clip((end - times) / (end - start), 0, 1)
    else:
        curve = np.clip((times - end) / (start - end), 0, 1)
    return np.asarray(sound * curve**2, np.float32)


def high_pass(sound: Mono) -> Mono:
    """Without what lies under hearing."""
    return np.asarray(signal.sosfilt(signal.butter(1, 20, "high", output="sos", fs=RATE), sound), np.float32)
