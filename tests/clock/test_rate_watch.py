"""A device that delivers more or fewer samples than it says."""

import numpy as np
import pytest

from live.clock.sample_clock import RateEstimator


def told(says: float, rate: float, *, jitter: float = 0.02, block: int = 512, lost: float = 0.0) -> list[float]:
    rng = np.random.default_rng(5)
    watch, found = RateEstimator(says), []
    frames = 0.0
    for n in range(int(40.0 * rate / block)):
        if rng.uniform() >= lost:
            frames += block
        new = watch.observe(frames, n * block / rate + rng.exponential(jitter))
        if new is not None:
            found.append(new)
    return found


@pytest.mark.parametrize("says", [22_050.0, 44_100.0, 48_000.0, 192_000.0])
def test_a_device_that_keeps_its_word_is_left_alone(says: float) -> None:
    assert told(says, says * 1.0001, block=1024) == []


@pytest.mark.parametrize(("says", "rate"), [(48_000.0, 44_100.0), (44_100.0, 48_000.0), (96_000.0, 48_000.0)])
def test_a_wrong_rate_is_found_once_and_named(says: float, rate: float) -> None:
    assert told(says, rate) == [rate]


def test_an_odd_rate_is_measured() -> None:
    (found,) = told(48_000.0, 52_800.0, jitter=0.002)
    assert found == pytest.approx(52_800.0, rel=0.01)


def test_lost_blocks_are_no_rate() -> None:
    assert told(48_000.0, 48_000.0, lost=0.02) == []


def test_a_machine_that_stood_still_says_nothing() -> None:
    watch = RateEstimator(48_000.0)
    for n in range(12):
        assert watch.observe(n * 4800.0, n * 30.0) is None
