"""RateEstimator: devices that deliver more or fewer samples than declared."""

import numpy as np
import pytest

from live.clock.sample_clock import RateEstimator


def estimate_rates(
    says: float, rate: float, *, jitter: float = 0.02, block: int = 512, lost: float = 0.0
) -> list[float]:
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
def test_device_at_declared_rate_is_not_reported(says: float) -> None:
    assert estimate_rates(says, says * 1.0001, block=1024) == []


@pytest.mark.parametrize(("says", "rate"), [(48_000.0, 44_100.0), (44_100.0, 48_000.0), (96_000.0, 48_000.0)])
def test_wrong_rate_is_reported_once(says: float, rate: float) -> None:
    assert estimate_rates(says, rate) == [rate]


def test_nonstandard_rate_is_measured() -> None:
    (found,) = estimate_rates(48_000.0, 52_800.0, jitter=0.002)
    assert found == pytest.approx(52_800.0, rel=0.01)


def test_lost_blocks_do_not_change_the_rate() -> None:
    assert estimate_rates(48_000.0, 48_000.0, lost=0.02) == []


def test_suspended_machine_gives_no_rate() -> None:
    watch = RateEstimator(48_000.0)
    for n in range(12):
        assert watch.observe(n * 4800.0, n * 30.0) is None
