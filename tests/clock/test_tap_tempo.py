"""TapTempo: tempo and phase from a series of taps."""

import numpy as np
import pytest

from live.clock.tap_tempo import TapTempo


def test_three_taps_give_a_grid() -> None:
    taps = TapTempo()
    assert taps.tap(10.0) is None
    assert taps.tap(10.5) is None
    grid = taps.tap(11.0)
    assert grid is not None
    assert grid.tempo == pytest.approx(120.0)
    assert grid.residual(12.5) == pytest.approx(0.0, abs=1e-9)


def test_jittered_taps_average_to_the_tempo() -> None:
    rng = np.random.default_rng(3)
    taps = TapTempo()
    grid = None
    for beat in range(12):
        grid = taps.tap(beat * 0.6 + rng.normal(0.0, 0.012))
    assert grid is not None
    assert grid.tempo == pytest.approx(100.0, rel=0.01)
    assert abs(grid.residual(0.0)) * grid.period < 0.012


def test_missed_tap_does_not_halve_the_tempo() -> None:
    taps = TapTempo()
    grid = None
    for time in (0.0, 0.5, 1.0, 2.0, 2.5, 3.0):
        grid = taps.tap(time)
    assert grid is not None
    assert grid.tempo == pytest.approx(120.0)


def test_key_bounce_counts_as_one_tap() -> None:
    taps = TapTempo()
    grid = None
    for time in (0.0, 0.02, 0.5, 0.53, 1.0, 1.04):
        grid = taps.tap(time) or grid
    assert grid is not None
    assert grid.tempo == pytest.approx(120.0)


def test_pause_of_two_seconds_starts_a_new_series() -> None:
    taps = TapTempo()
    for time in (0.0, 0.5, 1.0):
        taps.tap(time)
    assert taps.tap(3.5) is None
    assert taps.tap(4.5) is None
    grid = taps.tap(5.5)
    assert grid is not None
    assert grid.tempo == pytest.approx(60.0)


def test_absurd_tap_time_does_not_block_later_taps() -> None:
    taps = TapTempo()
    taps.tap(1e30)
    grid = None
    for time in (0.0, 0.5, 1.0):
        grid = taps.tap(time)
    assert grid is not None
    assert grid.tempo == pytest.approx(120.0)


def test_uneven_taps_give_a_grid() -> None:
    taps = TapTempo()
    for time in (0.0, 0.16):
        taps.tap(time)
    assert taps.tap(1.0) is not None
