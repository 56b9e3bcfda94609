"""Tests of claps with flashes: onset detection, and the display delay computed from claps."""

import numpy as np
import numpy.typing as npt
import pytest

from live.base.errors import PersonError
from live.control.audio.latency_claps import clap_offset, find_claps
from tests.fixtures.mostly_long import mostly_long

Float64 = npt.NDArray[np.float64]
FLASHES = 2.0 + np.arange(24) * 0.75


def synthesize_claps(
    claps: Float64, rate: float = 48_000.0, noise: float = 1e-3, loudness: float = 0.3
) -> npt.NDArray[np.float32]:
    """Claps: decaying bursts of noise with the hall's echo, over rumble and hiss."""
    rng = np.random.default_rng(4)
    t = np.arange(int(21.0 * rate)) / rate
    sound = rng.normal(0.0, noise, t.size) + 0.02 * np.sin(2.0 * np.pi * 50.0 * t)
    length = int(0.15 * rate)
    for clap in claps:
        start = int(np.ceil(clap * rate))
        burst = rng.normal(0.0, loudness, length) * np.exp(-np.arange(length) / (0.012 * rate))
        burst[int(0.03 * rate) :] += 0.3 * burst[: length - int(0.03 * rate)]
        sound[start : start + length] += burst[: max(len(sound) - start, 0)]
    return sound.astype(np.float32)


@mostly_long("rate", [22_050.0, 48_000.0, 96_000.0], quick=[0])
def test_clap_onsets_are_detected(rate: float) -> None:
    times = FLASHES + np.random.default_rng(5).uniform(-0.1, 0.1, 24)
    found = find_claps(synthesize_claps(times, rate), rate)
    assert len(found) == 24
    assert np.abs(found - times).max() < 0.0025


@mostly_long("late", [-0.03, 0.02, 0.125, 0.3], quick=[3])
def test_median_of_human_claps_is_the_delay(late: float) -> None:
    rng = np.random.default_rng(6)
    claps = FLASHES + late + rng.normal(0.0, 0.02, 24)
    claps[7] += 0.2  # a late comer
    offset = clap_offset(find_claps(synthesize_claps(np.delete(claps, [11, 12])), 48_000.0), FLASHES)
    assert offset.seconds == pytest.approx(late, abs=0.012)
    assert offset.claps >= 14


def test_first_claps_are_ignored() -> None:
    claps = FLASHES + 0.1
    claps[:4] -= 0.25
    assert clap_offset(claps, FLASHES).seconds == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("claps", "why"),
    [
        (np.zeros(0), "only 0 claps"),
        (FLASHES[:9], "only 5 claps"),
        (FLASHES + np.random.default_rng(7).uniform(-0.37, 0.37, 24), "scatter"),
    ],
)
def test_few_or_scattered_claps_are_refused_with_remedy(claps: Float64, why: str) -> None:
    with pytest.raises(PersonError, match=why) as caught:
        clap_offset(claps, FLASHES)
    assert caught.value.remedy


def test_noise_and_nan_contain_no_claps() -> None:
    assert len(find_claps(synthesize_claps(np.zeros(0), noise=0.01), 48_000.0)) == 0
    assert len(find_claps(np.full(48_000, np.nan, np.float32), 48_000.0)) == 0
