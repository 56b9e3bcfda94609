"""Tests of curves and filters: their properties, and scipy's PCHIP as an independent implementation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from live.motion.curve import (
    filter_samples,
    gaussian_filter,
    hermite,
    interpolate,
    monotone_slopes,
    repeat_keys,
    soft_min,
    spring_response,
)

keys = st.lists(st.tuples(st.floats(0.1, 2.0), st.floats(-3.0, 3.0)), min_size=2, max_size=8)


@given(keys)
def test_curve_meets_keys_without_overshoot(pairs: list[tuple[float, float]]) -> None:
    times = np.cumsum([gap for gap, _ in pairs])
    values = np.array([value for _, value in pairs])
    assert np.allclose(interpolate(times, values, times), values)
    for left in range(len(times) - 1):
        between = interpolate(times, values, np.linspace(times[left], times[left + 1], 30))
        low, high = sorted(values[left : left + 2])
        assert (between >= low - 1e-9).all()
        assert (between <= high + 1e-9).all()


def test_inner_slopes_match_pchip() -> None:
    random = np.random.default_rng(5)
    times, values = np.cumsum(random.uniform(0.2, 1.0, 20)), random.normal(size=20)
    expected = PchipInterpolator(times, values).derivative()(times)
    assert np.allclose(monotone_slopes(times, values)[1:-1], expected[1:-1])


def test_hermite_curve_reproduces_ballistic_parabola() -> None:
    time = np.linspace(0.0, 0.5, 50)
    speed = 9.81 * 0.25
    way = hermite(np.array((0.0, 0.5)), np.zeros(2), np.array((speed, -speed)), time)
    assert np.allclose(way, speed * time - 0.5 * 9.81 * time**2)


def test_values_are_held_outside_keys() -> None:
    at = np.linspace(-5.0, 5.0, 11)
    assert np.allclose(interpolate(np.array((1.0,)), np.array((2.0,)), at), 2.0)
    assert np.allclose(interpolate(np.array((0.0, 1.0)), np.array((2.0, 3.0)), at)[[0, -1]], (2.0, 3.0))


def test_repeated_keys_give_periodic_curve() -> None:
    at = np.linspace(-4.0, 8.0, 12 * 32 + 1)
    times, values = repeat_keys(np.array((0.5, 1.0, 3.0)), np.array((0.0, 1.0, -1.0)), 4.0, 0.25, at)
    curve = interpolate(times, values, at)
    assert np.allclose(curve[128:] - curve[:-128], 0.25)


@pytest.mark.parametrize("soften", [lambda x: gaussian_filter(x, 5.0), lambda x: spring_response(x, 16.0, 0.5)])
def test_filters_keep_constants_lines_and_period(soften) -> None:  # type: ignore[no-untyped-def]
    time = np.arange(400.0)
    assert np.allclose(soften(np.full((400, 2), 3.0)), 3.0)
    steady = soften(time)[100:300]
    assert np.allclose(np.diff(steady), 1.0)
    wave = soften(np.sin(2.0 * np.pi * time / 64.0))
    assert np.allclose(wave[100:236], wave[164:300])


def test_gaussian_has_no_delay_and_spring_has() -> None:
    step = (np.arange(200) >= 100).astype(float)
    assert gaussian_filter(step, 4.0)[99:101].mean() == pytest.approx(0.5)
    late = spring_response(step, 16.0, 0.4)
    assert np.allclose(late[:100], 0.0)
    assert late.max() > 1.05, "it swings through"
    assert late[-1] == pytest.approx(1.0, abs=1e-6)


def test_filter_applies_weights_to_past_samples() -> None:
    assert filter_samples(np.array((0.0, 0.0, 1.0, 0.0, 0.0)), np.array((0.25, 0.75)), 1).tolist() == [
        0,
        0,
        0.75,
        0.25,
        0,
    ]


@given(st.floats(-5.0, 5.0), st.floats(-5.0, 5.0), st.floats(0.001, 1.0))
def test_soft_minimum_is_just_below_minimum(a: float, b: float, width: float) -> None:
    least = float(soft_min(np.array(a), np.array(b), width))
    assert least <= min(a, b) + 1e-12
    assert least >= min(a, b) - 0.5 * width - 1e-12
