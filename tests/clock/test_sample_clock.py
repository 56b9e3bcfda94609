"""SampleClock: a straight line through callbacks with irregular timing."""

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


def largest_error(jitter: list[float], lost_every: int = 0, seconds: float = 40.0) -> float:
    """Largest error [s] after the first three seconds of late callbacks; every `lost_every`-th block is lost."""
    clock, frames, errors = SampleClock(RATE), 0, []
    for block in range(int(seconds * RATE / BLOCK)):
        true = 5.0 + (block + 1) * BLOCK / RATE
        if lost_every and block % lost_every == 0:
            continue
        frames += BLOCK
        clock.observe(frames, true + jitter[block % len(jitter)])
        if true > 8.0:
            errors.append(abs(clock.time_of(frames) - true))
    return max(errors)


def bunches(of: int) -> list[float]:
    """Blocks that all arrive with the last of a bunch."""
    return [(of - 1 - n) * BLOCK / RATE for n in range(of)]


def stalls(share: float, longest: float) -> list[float]:
    """Occasional stalls, after which all delayed blocks arrive at once."""
    rng = np.random.default_rng(2)
    free, late = 0.0, []
    for block in range(3001):
        time = block * BLOCK / RATE
        if rng.uniform() < share:
            free = max(free, time + rng.uniform(0.02, longest))
        late.append(max(free - time, 0.0) + rng.exponential(0.008))
    return late


@pytest.mark.parametrize(
    "jitter",
    [[*np.random.default_rng(1).exponential(0.006, 997)], bunches(4), bunches(9), stalls(0.05, 0.15)],
    ids=["late", "bunches of 4", "bunches of 9", "stalls"],
)
def test_bunched_and_late_callbacks_cause_less_than_a_millisecond_error(jitter: list[float]) -> None:
    assert largest_error(jitter) < 0.001


def test_periodic_block_loss_causes_at_most_one_block_error() -> None:
    jitter = [*np.random.default_rng(1).exponential(0.003, 997)]
    assert largest_error(jitter, lost_every=188) < 1.1 * BLOCK / RATE


def test_stall_mistaken_for_loss_is_corrected_at_once() -> None:
    clock = SampleClock(RATE)
    observe(clock, 0, 500, [0.0])
    observe(clock, 500, 120, [0.3])  # more than a second in which everything is late
    assert clock.jumps == 1
    observe(clock, 620, 1, [0.0])
    assert clock.time_of(620 * BLOCK) == pytest.approx(5.0 + 620 * BLOCK / RATE, abs=1e-4)


@pytest.mark.parametrize("ppm", [-100.0, 0.0, 120.0])
def test_clock_finds_the_true_device_rate(ppm: float) -> None:
    clock = SampleClock(RATE)
    observe(clock, 0, 1500, [0.0], ppm)
    ahead = 1500 * BLOCK + 10 * RATE
    assert clock.time_of(ahead) == pytest.approx(5.0 + ahead / RATE * (1.0 + ppm * 1e-6), abs=2e-4)


def test_single_outlier_callback_changes_nothing() -> None:
    clock = SampleClock(RATE)
    observe(clock, 0, 500, [0.0])
    before = clock.time_of(300_000)
    clock.observe(500 * BLOCK, 5.0 + 500 * BLOCK / RATE + 3.0)
    observe(clock, 501, 50, [0.0])
    assert clock.time_of(300_000) == pytest.approx(before, abs=1e-4)


def test_lost_samples_restart_the_line() -> None:
    clock = SampleClock(RATE)
    observe(clock, 0, 500, [0.0])
    observe(clock, 500, 60, [0.0], lost=0.2)
    assert clock.jumps == 1
    frame = 559 * BLOCK
    assert clock.time_of(frame) == pytest.approx(5.0 + frame / RATE + 0.2, abs=1e-3)


def test_frame_at_is_the_inverse_of_time_of() -> None:
    clock = SampleClock(RATE)
    observe(clock, 0, 1200, [0.0], 80.0)
    assert clock.frame_at(clock.time_of(500_000.0)) == pytest.approx(500_000.0, abs=0.1)
