"""The sounds of a tap shoe and of a click track, made from nothing but numbers (T130)."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]
Float32 = npt.NDArray[np.float32]

TAP_SECONDS: Final = 0.12
CLICK_SECONDS: Final = 0.035
ACCENT_HZ: Final = 1760.0
BEAT_HZ: Final = 1175.0
VARIANTS: Final = 6
"""Shoes that sound a little different, so that a line of dancers is no machine gun."""


@dataclass(frozen=True, slots=True)
class _Plate:
    """What rings when a part of the shoe strikes: metal (frequency [Hz], decay [s], level), and the wooden floor."""

    metal: tuple[tuple[float, float, float], ...]
    wood: tuple[tuple[float, float, float], ...]
    noise: float
    """Level of the first contact's rustle."""


_BALL: Final = _Plate(
    metal=((2350.0, 0.012, 0.9), (3720.0, 0.008, 0.7), (5480.0, 0.005, 0.5)),
    wood=((310.0, 0.016, 0.45), (520.0, 0.010, 0.35)),
    noise=0.9,
)
_HEEL: Final = _Plate(
    metal=((1480.0, 0.016, 0.8), (2610.0, 0.010, 0.6), (4300.0, 0.005, 0.3)),
    wood=((165.0, 0.030, 0.9), (270.0, 0.020, 0.6)),
    noise=0.6,
)


def tap_voices(seed: int, rate: int) -> list[list[Float32]]:
    """Sounds of `TAP_SECONDS` at `rate` [Hz] with peak 1, in VARIANTS: lists for ball, heel and flat foot.

    The same seed gives the same shoes.
    """
    chance = np.random.default_rng([seed, 0x7A9])
    ball = [_strike(_BALL, chance, rate) for _ in range(VARIANTS)]
    heel = [_strike(_HEEL, chance, rate) for _ in range(VARIANTS)]
    late = max(1, round(0.002 * rate))  # heel and ball of a flat foot are never quite together
    flat = [_loudest(h + 0.8 * np.concatenate((np.zeros(late), b[:-late]))) for b, h in zip(ball, heel, strict=True)]
    return [[voice.astype(np.float32) for voice in voices] for voices in (ball, heel, flat)]


def click_voices(rate: int) -> tuple[Float32, Float32]:
    """The click of a measure's first beat, and that of all others, at `rate` [Hz] with peak 1."""
    return _click(ACCENT_HZ, rate), _click(BEAT_HZ, rate)


def _strike(plate: _Plate, chance: np.random.Generator, rate: int) -> Float64:
    time = np.arange(round(TAP_SECONDS * rate)) / rate
    detune = 1.0 + 0.05 * chance.uniform(-1.0, 1.0)
    sound = plate.noise * np.diff(chance.standard_normal(len(time) + 1)) * np.exp(-time / 0.0015)
    for ring, spread in ((plate.metal, 0.03), (plate.wood, 0.06)):
        for frequency, decay, level in ring:
            hertz = frequency * detune * (1.0 + spread * chance.uniform(-1.0, 1.0))
            if hertz < 0.45 * rate:
                sound += level * np.sin(2.0 * math.pi * hertz * time) * np.exp(-time / decay)
    return _loudest(sound * _fade_out(len(time)))


def _click(hertz: float, rate: int) -> Float32:
    time = np.arange(round(CLICK_SECONDS * rate)) / rate
    sound = np.sin(2.0 * math.pi * hertz * time) * np.exp(-time / 0.007)
    return _loudest(sound * _fade_out(len(time))).astype(np.float32)


def _fade_out(count: int) -> Float64:
    return np.asarray(np.minimum(1.0, 8.0 * np.arange(count, 0, -1) / count))


def _loudest(sound: Float64) -> Float64:
    return np.asarray(sound / max(float(np.abs(sound).max()), 1e-9))
