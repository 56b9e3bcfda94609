"""Tests of beat grid fitting: properties over synthetic events with gaps and strays, and exact small cases."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.motion.beats.beat_grid_fit import fit_free_period, fit_known_period

OFFSETS = st.floats(0.0, 3.0)
TEMPI = st.floats(50.0, 200.0)
SEEDS = st.integers(0, 10_000)


def beat_offset_distance(a: float, b: float, period: float) -> float:
    """Distance between two offsets, modulo whole beats."""
    late = a - b
    return abs(late - period * round(late / period))


@given(OFFSETS, TEMPI, SEEDS)
def test_offset_is_found_for_known_tempo(offset: float, bpm: float, seed: int) -> None:
    """Twelve beats, 8 ms of scatter, three missing, one stray: the offset is right to 15 ms."""
    random = np.random.default_rng(seed)
    period = 60.0 / bpm
    beats = offset + period * np.sort(random.choice(12, 9, replace=False)) + random.normal(0.0, 0.008, 9)
    stray = offset + period * (random.integers(0, 11) + 0.5)
    fit = fit_known_period(np.sort(np.append(beats, stray)), period)
    assert beat_offset_distance(fit.offset_s, offset, period) < 0.015
    assert int(fit.on_beat.sum()) == 9
    assert fit.rms_s < 0.02


@pytest.mark.long
@given(OFFSETS, TEMPI, SEEDS)
def test_free_fit_finds_tempo_and_offset(offset: float, bpm: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    period = 60.0 / bpm
    beats = offset + period * np.arange(8) + random.normal(0.0, 0.006, 8)
    kept = np.delete(beats, random.integers(1, 7))
    fit = fit_free_period(np.sort(kept))
    assert fit is not None
    assert fit.period_s == pytest.approx(period, rel=0.015)
    assert beat_offset_distance(fit.offset_s, offset, period) < 0.03
    assert fit.coverage == pytest.approx(7 / 8)


def test_exact_beats_fit_exactly() -> None:
    fit = fit_free_period(1.25 + 0.5 * np.arange(6))
    assert fit is not None
    assert fit.period_s == pytest.approx(0.5, abs=1e-9)
    assert fit.offset_s % 0.5 == pytest.approx(0.25, abs=1e-9)
    assert np.diff(fit.numbers).tolist() == [1] * 5
    assert fit.on_beat.all()
    assert fit.rms_s < 1e-9
    assert fit.coverage == 1.0


def test_nearer_of_two_events_is_assigned_to_beat() -> None:
    fit = fit_known_period(np.array([1.0, 1.5, 1.53, 2.0]), 0.5)
    assert fit.on_beat.tolist() == [True, True, False, True]


def test_single_offbeat_event_does_not_halve_period() -> None:
    """A single event between two beats does not halve the period."""
    fit = fit_free_period(np.array([1.0, 1.6, 2.2, 2.5, 2.8, 3.4, 4.0]))
    assert fit is not None
    assert fit.period_s == pytest.approx(0.6, abs=0.005)
    assert int(fit.on_beat.sum()) == 6


def test_fewer_than_three_events_have_no_beat() -> None:
    assert fit_free_period(np.array([1.0, 1.5])) is None
    assert fit_free_period(np.zeros(0)) is None
