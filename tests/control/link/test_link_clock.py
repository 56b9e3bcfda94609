"""Tests of the conversion from Link's clock to the show's: drift, jitter, interruptions, rate changes by NTP."""

import time

import numpy as np
import pytest

from live.control.link.link_session import LinkClock


def conversion_errors(
    line: LinkClock, rng: np.random.Generator, offsets: np.ndarray, step: float, wide: float
) -> list[float]:
    """Errors [s] of the conversion half a second ahead; the show's clock is Link's + offset at each reading."""
    errors = []
    for index, offset in enumerate(offsets):
        link = 1000.0 + index * step
        half = rng.uniform(0.3e-6, 2e-6) if rng.random() > 0.1 else rng.uniform(1e-6, wide)
        show = link + offset + rng.uniform(-half, half)  # anywhere within the bracket
        line.observe(show - half, round(link * 1e6), show + half)
        if index + 2 < len(offsets):
            ahead = link + 2 * step
            errors.append(line.time_of(ahead * 1e6) - (ahead + offsets[index + 2]))
    return errors


@pytest.mark.parametrize("ppm", [50.0, -50.0, 500.0, 0.0])
def test_drift_and_jitter_errors_stay_below_tenth_millisecond(ppm: float) -> None:
    rng = np.random.default_rng(3)
    offsets = 0.249 + ppm * 1e-6 * np.arange(400) * 0.25
    line = LinkClock()
    errors = np.abs(conversion_errors(line, rng, offsets, 0.25, wide=150e-6))
    assert np.percentile(errors, 95) < 0.1e-3
    assert errors.max() < 0.4e-3  # the first ones, before a rate is known, at 500 ppm
    assert abs(line.rate * 1e6 - ppm) < 60.0


def test_interrupted_reading_is_ignored() -> None:
    line = LinkClock()
    for index in range(20):
        line.observe(index * 0.25, index * 250_000, index * 0.25 + 1e-6)
    line.observe(5.0, 5_009_900, 5.010)  # we were away between the two looks: the middle would be 5 ms wrong
    assert line.time_of(5_100_000) == pytest.approx(5.1, abs=2e-6)
    for late in (7.5, 8.0):  # but better a wide one than one of long ago
        line.observe(late, round(late * 1e6) + 1000, late + 0.002)
    assert line.error == pytest.approx(1e-3)


def test_rate_change_by_ntp_is_followed_immediately() -> None:
    """From 0 to 500 ppm: a line through all readings would be wrong by milliseconds."""
    step = 0.25
    bent = np.concatenate([np.zeros(60), 500e-6 * step * np.arange(60)])
    errors = np.abs(conversion_errors(LinkClock(), np.random.default_rng(5), bent, step, wide=20e-6))
    assert errors.max() < 0.4e-3


def test_microsecond_rounding_gives_zero_rate() -> None:
    """Frequent, exactly bracketed readings of clocks with equal rates: up to a microsecond is truncated."""
    line, rng = LinkClock(), np.random.default_rng(9)
    for at in np.cumsum(rng.uniform(10e-6, 400e-6, 500)):
        line.observe(at, int(at * 1e6), at)
        assert line.rate == 0.0


@pytest.mark.long
def test_raw_clock_converts_to_perf_counter() -> None:
    """CLOCK_MONOTONIC_RAW, which Link counts, against perf_counter, for a second."""
    raw = getattr(time, "CLOCK_MONOTONIC_RAW", None)
    if raw is None:
        pytest.skip("this system has no CLOCK_MONOTONIC_RAW")
    line = LinkClock()
    worst = 0.0
    deadline = time.perf_counter() + 1.0
    while time.perf_counter() < deadline:
        line.read(lambda: time.clock_gettime_ns(raw) // 1000, time.perf_counter)
        for _ in range(50):
            before = time.perf_counter()
            micros = time.clock_gettime_ns(raw) / 1000
            after = time.perf_counter()
            outside = max(before - line.time_of(micros), line.time_of(micros) - after, 0.0)
            worst = max(worst, outside - line.error)
    assert worst < 0.2e-3
    assert abs(line.rate) < 600e-6
