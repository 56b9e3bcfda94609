"""Spectrum and bands: known tones, any rate, any block size, and invalid samples."""

import tracemalloc

import numpy as np
import pytest

from live.clock.tracking.feature_kernels import LEVEL_FLOOR, follow_level
from live.clock.tracking.features import (
    ANALYSIS_WINDOWS,
    BAND_COUNT,
    BANDS_PER_WINDOW,
    HOP,
    Samples,
    Spectrum,
    band_centres,
    filters,
    window_length,
)
from tests.clock.clicks import groove

RATE = 44_100


def compute_bands(sound: Samples, rate: int = RATE, block: int = 512) -> np.ndarray:
    """Bands of all frames, shape (frames, bands)."""
    spectrum, out = Spectrum(rate), []
    for first in range(0, sound.size, block):
        samples = sound[first : first + block]
        start = 0
        while start < samples.size:
            start += spectrum.feed(samples, start)
            if spectrum.wanted == 0:
                spectrum.analyse()
                out.append(spectrum.bands.copy())
    return np.array(out)


def tone(hertz: float, rate: int = RATE) -> Samples:
    return np.sin(2.0 * np.pi * hertz * np.arange(rate // 4) / rate).astype(np.float32)


@pytest.mark.parametrize("hertz", [110.0, 1000.0, 5000.0])
@pytest.mark.parametrize("rate", [22_050, 44_100, 48_000])
def test_tone_is_strongest_in_its_own_band(hertz: float, rate: int) -> None:
    last = compute_bands(tone(hertz, rate), rate)[-1]
    short = band_centres(ANALYSIS_WINDOWS[0])[1:-1]
    assert abs(np.argmax(last[: BANDS_PER_WINDOW[0]]) - np.argmin(np.abs(short - hertz))) <= 1
    assert 0.2 < last[: BANDS_PER_WINDOW[0]].max() < 2.5


@pytest.mark.parametrize("rate", [22_050, 32_000, 48_000, 192_000])
def test_bands_are_independent_of_sample_rate(rate: int) -> None:
    time = np.arange(2 * rate) / rate
    sound = sum(np.sin(2 * np.pi * f * time) * (np.sin(2 * np.pi * 3 * time) > 0) for f in (110, 330, 1200, 4000))
    base = np.arange(2 * RATE) / RATE
    same = sum(np.sin(2 * np.pi * f * base) * (np.sin(2 * np.pi * 3 * base) > 0) for f in (110, 330, 1200, 4000))
    got, expected = compute_bands(sound.astype(np.float32), rate), compute_bands(same.astype(np.float32))
    assert abs(len(got) - len(expected)) <= 1
    frames = min(len(got), len(expected))
    loud = expected[:frames].mean(axis=0) > 0.05
    off = np.abs(got[:frames, loud] - expected[:frames, loud])
    assert off.mean() < 0.03 * expected[:frames, loud].mean()


def test_white_noise_level_grows_with_root_of_bandwidth() -> None:
    noise = np.random.default_rng(1).normal(0.0, 0.1, 5 * RATE).astype(np.float32)
    mean = compute_bands(noise)[20:].mean(axis=0)[: BANDS_PER_WINDOW[0]]
    edges = band_centres(ANALYSIS_WINDOWS[0])
    width = 0.5 * (edges[2:] - edges[:-2]) / (RATE / ANALYSIS_WINDOWS[0].window)
    ratio = mean / np.sqrt(np.maximum(width, 1.0))
    assert np.abs(ratio[3:] / np.median(ratio) - 1.0).max() < 0.15


@pytest.mark.parametrize("block", [1, 500, 44_100])
def test_frames_are_independent_of_block_size(block: int) -> None:
    sound = groove(120, RATE, 1.0)
    np.testing.assert_array_equal(compute_bands(sound, block=block), compute_bands(sound))


@pytest.mark.parametrize("rate", [22_050, 44_100, 48_000, 95_999, 192_000])
def test_frame_times_are_equal_at_every_rate(rate: int) -> None:
    spectrum = Spectrum(rate)
    for frame in range(1, 1000, 7):
        spectrum.frames = frame - 1
        assert abs(spectrum.next_end / rate - frame * HOP) <= 1.0 / rate
    assert all(abs(window_length(ear, rate) / rate / (ear.window / RATE) - 1.0) < 0.006 for ear in ANALYSIS_WINDOWS)


def test_only_bands_above_nyquist_are_empty() -> None:
    for ear in ANALYSIS_WINDOWS:
        for rate in (22_050, 48_000):
            kept = filters(ear, rate, window_length(ear, rate))
            beyond = band_centres(ear)[2:] > 0.5 * rate
            np.testing.assert_array_equal(np.diff(kept.offset) == 0, beyond)


def test_invalid_samples_are_counted_and_silenced() -> None:
    sound = groove(120, RATE, 1.0)
    sound[1000:1010] = np.nan
    sound[2000], sound[2001] = np.inf, 1e9
    spectrum = Spectrum(RATE)
    start = 0
    while start < sound.size:
        start += spectrum.feed(sound, start)
        if spectrum.wanted == 0:
            spectrum.analyse()
            assert np.isfinite(spectrum.bands).all()
    assert spectrum.bad_samples == 12


@pytest.mark.parametrize("rate", [8_000, 0, -1, float("nan"), 1e6])
def test_invalid_sample_rates_are_refused(rate: float) -> None:
    with pytest.raises(ValueError, match="a sample rate of"):
        Spectrum(rate)


def test_level_follows_a_fade_and_rises_at_once() -> None:
    level = LEVEL_FLOOR
    for frame in range(2000):  # 23 s, -46 dB
        loud = np.full(BAND_COUNT, 0.1 * 10.0 ** (-46.0 / 20.0 * frame / 2000.0), np.float32)
        level = follow_level(loud, level)
        assert level >= loud[0] / 4.0
    assert level < 6.0 * loud[0]
    assert follow_level(np.ones(BAND_COUNT, np.float32), level) >= 0.25
    for _ in range(5000):
        level = follow_level(np.zeros(BAND_COUNT, np.float32), level)
    assert level == LEVEL_FLOOR


def test_analysis_allocates_nothing() -> None:
    spectrum, sound = Spectrum(RATE), groove(120, RATE, 2.0)

    def work(first: int, last: int) -> None:
        start = first
        while start < last:
            start += spectrum.feed(sound, start)
            if spectrum.wanted == 0:
                spectrum.analyse()

    work(0, RATE)
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    work(RATE, 2 * RATE)
    grown = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    assert grown < 2048
