"""Tests of band decomposition: sum, lines, shift invariance and octaves of the bands."""

import numpy as np
import pytest

from live.motion.texture.frequency_bands import RATE, low_pass, split_bands

CHANCE = np.random.default_rng(1)


@pytest.mark.parametrize("length", [1, 2, 3, 5, 17, 100, 300])
def test_bands_sum_to_signal(length: int) -> None:
    signal = CHANCE.normal(size=(length, 4))
    bands = split_bands(signal, 8)
    assert bands.shape == (9, length, 4)
    assert np.abs(bands.sum(axis=0) - signal).max() < 1e-12


def test_bands_are_zero_at_ends_and_for_lines() -> None:
    bands = split_bands(CHANCE.normal(size=(90, 2)), 7)
    assert np.abs(bands[:-1, [0, -1]]).max() < 1e-12
    line = np.linspace(3.0, -5.0, 60)[:, None]
    assert np.abs(split_bands(line, 7)[:-1]).max() < 1e-12


def test_low_pass_equals_filter_with_repeated_reflection() -> None:
    signal = CHANCE.normal(size=(40, 2))
    for spacing in (1, 4, 16, 32):
        wide = np.concatenate([_reflected_sample(signal, n)[None] for n in range(-2 * spacing, 40 + 2 * spacing)])
        taps = np.array((1.0, 4.0, 6.0, 4.0, 1.0)) / 16.0
        by_hand = sum(w * wide[k * spacing : k * spacing + 40] for k, w in enumerate(taps))
        assert np.abs(low_pass(signal, spacing) - by_hand).max() < 1e-12


def _reflected_sample(signal: np.ndarray, place: int) -> np.ndarray:
    last = len(signal) - 1
    if place < 0:
        return 2.0 * signal[0] - _reflected_sample(signal, -place)
    if place > last:
        return 2.0 * signal[-1] - _reflected_sample(signal, 2 * last - place)
    return signal[place]


def test_bands_are_shift_invariant() -> None:
    long = CHANCE.normal(size=400)
    first, second = split_bands(long[:380], 4), split_bands(long[7:387], 4)
    inside = slice(100, 260)
    assert np.abs(first[:, 107:267] - second[:, inside]).max() < 1e-12


@pytest.mark.parametrize(("hertz", "band"), [(9.0, 1), (4.2, 2), (2.1, 3), (1.05, 4), (0.5, 5), (0.26, 6)])
def test_band_contains_its_octave(hertz: float, band: int) -> None:
    wave = np.sin(2.0 * np.pi * hertz * np.arange(960) / RATE)
    energy = (split_bands(wave, 8)[:-1, 200:-200] ** 2).sum(axis=1)
    assert int(np.argmax(energy)) == band - 1
