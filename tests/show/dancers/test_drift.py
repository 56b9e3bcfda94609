"""Tests of timing drift: lookahead, continuity over measures, splines, phase and shared timing of partners."""

import numpy as np
import pytest

from live.show.dancers.rng import Purpose, generator_for
from live.show.dancers.timing_offsets import MAX_DRIFT_FREQUENCY, MIN_DRIFT_FREQUENCY, Drift

COUNT = 20
MOST = np.full(COUNT, 0.1)
EVERYBODY = np.arange(COUNT)
ITSELF = np.arange(COUNT, dtype=np.int32)


def sample_drift(drift, measures, *, ahead):
    found = []
    for measure in measures:
        drift.begin_measure(measure)
        if ahead:
            drift.draw_knots(measure + 4)
        found += [drift_at(drift, t) for t in np.linspace(0.0, 1.0, 9)]
    return np.array(found)


def drift_at(drift, t, *, rows=EVERYBODY, liked=ITSELF, like=ITSELF):
    out = np.empty(len(rows))
    drift.at(out, rows, t, MOST, liked, like)
    return out


def spline(knots, x):
    """A uniform cubic B-spline by the Cox-de Boor recursion; `knots` (n, A) are its values at integers."""

    def basis(k, order, x):
        if order == 0:
            return ((k <= x) & (x < k + 1)).astype(float)
        rise, fall = (x - k) / order, (k + order + 1 - x) / order
        return rise * basis(k, order - 1, x) + fall * basis(k + 1, order - 1, x)

    return sum(basis(k - 3, 3, x)[:, None] * knots[k] for k in range(len(knots)))


def test_knots_drawn_ahead_give_same_drift():
    plain, foreseen = (
        sample_drift(Drift(COUNT, 3), range(9), ahead=False),
        sample_drift(Drift(COUNT, 3), range(9), ahead=True),
    )
    assert np.array_equal(plain, foreseen)
    assert not np.array_equal(plain, sample_drift(Drift(COUNT, 4), range(9), ahead=False))


def test_drift_is_continuous_at_measure_lines_and_within_limit():
    found = sample_drift(Drift(COUNT, 1), range(12), ahead=False).reshape(12, 9, COUNT)
    assert found[1:, 0] == pytest.approx(found[:-1, -1], abs=1e-9)
    assert 0.01 < np.abs(found).max() <= 0.1


def test_amplitude_and_frequency_are_splines_and_phase_is_integral():
    drift, size = Drift(COUNT, 5), 4000
    drift.begin_measure(0)
    knots, begin = drift._knots, drift.phase
    x = (np.arange(size) + 0.5) / size
    phase = begin + 2.0 * np.pi * np.cumsum(spline(knots[1], x), axis=0) / size
    expected = MOST * spline(knots[0], x + 0.5 / size - 1e-12) * np.sin(phase)
    for n in (0, 799, 2500, 3999):
        assert drift_at(drift, (n + 1) / size) == pytest.approx(expected[n], abs=1e-7)


def test_row_subset_matches_all_rows_and_partners_blend_timing():
    drift = Drift(COUNT, 6)
    drift.begin_measure(0)
    rows = np.array([7, 2, 19])
    assert np.array_equal(drift_at(drift, 0.3, rows=rows), drift_at(drift, 0.3)[rows])
    like = ITSELF.copy()
    like[4] = 9
    for t, share in ((0.0, 0.0), (0.5, 0.5), (1.0, 1.0)):
        alone, together = drift_at(drift, t), drift_at(drift, t, like=like)
        assert together[4] == pytest.approx((1.0 - share) * alone[4] + share * alone[9], abs=1e-15)
        assert np.array_equal(np.delete(together, 4), np.delete(alone, 4))


def test_phase_advances_within_frequency_limits():
    drift = Drift(COUNT, 2)
    before = drift.phase.copy()
    for measure in range(50):
        drift.begin_measure(measure)
    cycles = (drift.phase - before) / (2.0 * np.pi * 49)
    assert (cycles >= MIN_DRIFT_FREQUENCY).all()
    assert (cycles <= MAX_DRIFT_FREQUENCY).all()


def test_random_streams_differ_by_seed_purpose_and_measure():
    drawn = [
        generator_for(seed, purpose, measure).uniform(size=3).tobytes()
        for seed in (1, 2)
        for purpose in Purpose
        for measure in (-1, 0, 1)
    ]
    assert len(set(drawn)) == len(drawn)
