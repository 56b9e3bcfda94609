"""Drift: the same whether it is drawn ahead or not, from the phase on where the last measure has left it."""

import numpy as np
import pytest

from live.show.dancers.rng import Purpose, generator_for
from live.show.dancers.timing_offsets import MAX_DRIFT_FREQUENCY, MIN_DRIFT_FREQUENCY, Drift

COUNT = 20
MOST = np.full(COUNT, 0.1)
EVERYBODY = np.arange(COUNT)
ITSELF = np.arange(COUNT, dtype=np.int32)


def danced(drift, measures, *, ahead):
    found = []
    for measure in measures:
        drift.begin_measure(measure)
        if ahead:
            drift.draw_knots(measure + 4)
        found += [ahead_at(drift, t) for t in np.linspace(0.0, 1.0, 9)]
    return np.array(found)


def ahead_at(drift, t, *, rows=EVERYBODY, liked=ITSELF, like=ITSELF):
    out = np.empty(len(rows))
    drift.at(out, rows, t, MOST, liked, like)
    return out


def spline(knots, x):
    """A uniform cubic B-spline by Cox and de Boor's recursion, `knots` (n, A) its values at whole numbers."""

    def basis(k, order, x):
        if order == 0:
            return ((k <= x) & (x < k + 1)).astype(float)
        rise, fall = (x - k) / order, (k + order + 1 - x) / order
        return rise * basis(k, order - 1, x) + fall * basis(k + 1, order - 1, x)

    return sum(basis(k - 3, 3, x)[:, None] * knots[k] for k in range(len(knots)))


def test_drawn_ahead_it_is_the_same():
    plain, foreseen = danced(Drift(COUNT, 3), range(9), ahead=False), danced(Drift(COUNT, 3), range(9), ahead=True)
    assert np.array_equal(plain, foreseen)
    assert not np.array_equal(plain, danced(Drift(COUNT, 4), range(9), ahead=False))


def test_no_step_at_the_lines_and_never_farther_than_asked():
    found = danced(Drift(COUNT, 1), range(12), ahead=False).reshape(12, 9, COUNT)
    assert found[1:, 0] == pytest.approx(found[:-1, -1], abs=1e-9)
    assert 0.01 < np.abs(found).max() <= 0.1


def test_amplitude_and_frequency_are_splines_and_the_phase_is_an_integral():
    drift, size = Drift(COUNT, 5), 4000
    drift.begin_measure(0)
    knots, begin = drift._knots, drift.phase
    x = (np.arange(size) + 0.5) / size
    phase = begin + 2.0 * np.pi * np.cumsum(spline(knots[1], x), axis=0) / size
    expected = MOST * spline(knots[0], x + 0.5 / size - 1e-12) * np.sin(phase)
    for n in (0, 799, 2500, 3999):
        assert ahead_at(drift, (n + 1) / size) == pytest.approx(expected[n], abs=1e-7)


def test_some_drift_as_all_do_and_partners_go_over_to_each_others_timing():
    drift = Drift(COUNT, 6)
    drift.begin_measure(0)
    rows = np.array([7, 2, 19])
    assert np.array_equal(ahead_at(drift, 0.3, rows=rows), ahead_at(drift, 0.3)[rows])
    like = ITSELF.copy()
    like[4] = 9
    for t, share in ((0.0, 0.0), (0.5, 0.5), (1.0, 1.0)):
        alone, together = ahead_at(drift, t), ahead_at(drift, t, like=like)
        assert together[4] == pytest.approx((1.0 - share) * alone[4] + share * alone[9], abs=1e-15)
        assert np.array_equal(np.delete(together, 4), np.delete(alone, 4))


def test_the_phase_goes_on_as_fast_as_the_frequencies_say():
    drift = Drift(COUNT, 2)
    before = drift.phase.copy()
    for measure in range(50):
        drift.begin_measure(measure)
    cycles = (drift.phase - before) / (2.0 * np.pi * 49)
    assert (cycles >= MIN_DRIFT_FREQUENCY).all()
    assert (cycles <= MAX_DRIFT_FREQUENCY).all()


def test_every_purpose_and_measure_has_chances_of_its_own():
    drawn = [
        generator_for(seed, purpose, measure).uniform(size=3).tobytes()
        for seed in (1, 2)
        for purpose in Purpose
        for measure in (-1, 0, 1)
    ]
    assert len(set(drawn)) == len(drawn)
