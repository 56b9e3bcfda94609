"""Tests of velocity changes and accelerations: motions with known derivatives, and random windows of raw clips."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.motion.quality.metrics import (
    accelerations,
    half_width,
    largest_around,
    largest_at_samples,
    raw_p99,
    velocity_changes,
)


def test_parabola_acceleration_and_kink_velocity_change_are_exact():
    time = np.arange(60) / 60.0
    position = np.zeros((60, 3, 3))
    position[:, 1, 0] = 2.0 * time**2  # 4 m/s²
    position[30:, 2, 2] = 1.5 * (time[30:] - time[30])  # from 0 to 1.5 m/s
    change, acceleration = velocity_changes(position, 60.0), accelerations(position, 60.0)
    assert change.shape == (58, 3)
    assert acceleration.shape == (56, 3)
    np.testing.assert_allclose(acceleration[:, 1], 4.0, atol=1e-9)
    np.testing.assert_allclose(change[:, 1], 4.0 / 60.0, atol=1e-9)
    assert change[:, 2].max() == pytest.approx(1.5)
    assert int(change[:, 2].argmax()) + 1 == 30
    assert acceleration[:, 2].max() == pytest.approx(1.5 * 60.0 / 3.0)
    largest = largest_at_samples(position, 60.0)
    assert largest[0][30] == pytest.approx(1.5)
    assert largest[0][[0, -1]].tolist() == [0.0, 0.0]
    assert largest[1][[0, 1, -2, -1]].tolist() == [0.0] * 4


@pytest.mark.parametrize("count", range(6))
def test_short_motions_have_zero_derivatives(count):
    change, acceleration = largest_at_samples(np.zeros((count, 2, 22, 3)), 60.0)
    assert change.shape == acceleration.shape == (count, 2)
    assert not change.any()
    assert not acceleration.any()


@given(st.integers(0, 2**32 - 1), st.integers(1, 200), st.floats(0.05, 1.0))
def test_largest_value_around_time_equals_loop_result(seed, count, half):
    chance = np.random.default_rng(seed)
    values, middle = chance.uniform(0.0, 1.0, count), chance.uniform(0.0, count / 60.0, 5)
    found = largest_around(values, middle, half, 60.0)
    for time, value in zip(middle, found, strict=True):
        inside = [values[n] for n in range(count) if abs(n / 60.0 - time) <= half]
        if inside:
            assert value == max(inside)
        assert value in values


def test_window_covers_blend():
    assert half_width(0.2) == 0.2
    assert half_width(0.5) == pytest.approx(0.3)


def test_raw_p99_equals_p99_of_all_windows():
    """A trace with a spike in 3 % of all windows, and one in 0.2 %."""
    trace = np.ones(20_000)
    trace[5000:5560] = 3.0
    trace[12_000:12_010] = 50.0
    assert raw_p99([trace], 0.1, 60.0) == 3.0
    windows = np.lib.stride_tricks.sliding_window_view(trace, 13).max(axis=1)
    assert np.percentile(windows, 99) == 3.0
    assert raw_p99([], 0.1, 60.0) == 0.0
    assert raw_p99([np.array([1.0, 2.0]), np.array([3.0])], 0.2, 60.0) == 3.0


def test_longer_clips_have_more_weight():
    short, long = np.full(100, 9.0), np.full(100_000, 1.0)
    assert raw_p99([short, long], 0.1, 60.0) == 1.0
    assert raw_p99([short, long[:2000]], 0.1, 60.0) == 9.0


def test_raw_p99_is_deterministic():
    trace = np.random.default_rng(1).uniform(size=5000) ** math.pi
    assert raw_p99([trace], 0.2, 60.0) == raw_p99([trace], 0.2, 60.0)
