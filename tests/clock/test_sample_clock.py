"""SampleClock: a straight line through callbacks that come when they like."""

import numpy as np
import pytest

from live.clock.sample_clock import SampleClock

RATE = 48_000.0
BLOCK = 512


def observe(
    clock: SampleClock, start: int, count: int, jitter: list[float], ppm: float = 0.0, lost: float = 0.0
) -> None:
    for block in range(start, start + count):
        frame = block * BLOCK
        clock.observe(frame, 5.0 + frame / RATE * (1.0 + ppm * 1e-6) + lost + jitter[block % len(jitter)])


def test_bunched_and_late_callbacks_average_out() -> None:
    rng = np.random.default_rng(1)
    clock = SampleClock(RATE)
    jitter = [*rng.exponential(0.006, 997)]
    observe(clock, 0, 2000, jitter)
    errors = [clock.time_of(frame) - (5.0 + frame / RATE) for frame in range(900_000, 1_000_000, 10_000)]
    assert np.std(errors) < 0.0003
    assert np.mean(errors) == pytest.approx(np.median(jitter), abs=0.001)


@pytest.mark.parametrize("ppm", [-100.0, 0.0, 120.0])
def test_finds_the_devices_true_rate(ppm: float) -> None:
    clock = SampleClock(RATE)
    observe(clock, 0, 1500, [0.0], ppm)
    ahead = 1500 * BLOCK + 10 * RATE
    assert clock.time_of(ahead) == pytest.approx(5.0 + ahead / RATE * (1.0 + ppm * 1e-6), abs=2e-4)


def test_one_wild_callback_changes_nothing() -> None:
    clock = SampleClock(RATE)
    observe(clock, 0, 500, [0.0])
    before = clock.time_of(300_000)
    clock.observe(500 * BLOCK, 5.0 + 500 * BLOCK / RATE + 3.0)
    observe(clock, 501, 50, [0.0])
    assert clock.time_of(300_000) == pytest.approx(before, abs=1e-4)


def test_lost_samples_begin_the_line_anew() -> None:
    clock = SampleClock(RATE)
    observe(clock, 0, 500, [0.0])
    observe(clock, 500, 40, [0.0], lost=0.2)
    assert clock.jumps == 1
    frame = 539 * BLOCK
    assert clock.time_of(frame) == pytest.approx(5.0 + frame / RATE + 0.2, abs=1e-3)


def test_frame_at_is_the_inverse() -> None:
    clock = SampleClock(RATE)
    observe(clock, 0, 1200, [0.0], 80.0)
    assert clock.frame_at(clock.time_of(500_000.0)) == pytest.approx(500_000.0, abs=0.1)
