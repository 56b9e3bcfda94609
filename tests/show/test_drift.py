"""Drift: the same whether it is drawn ahead or not, from the phase on where the last measure has left it."""

import numpy as np
import pytest

from live.show.chance import Purpose, chance_of
from live.show.drift import KNOT_HIGH, KNOT_LOW, Drift

COUNT = 20
MOST = np.full(COUNT, 0.1)


def danced(drift, measures, *, ahead):
    found = []
    for measure in measures:
        drift.begin_measure(measure)
        if ahead:
            drift.foresee(measure + 4)
        found += [drift.at(t, MOST) for t in np.linspace(0.0, 1.0, 9)]
    return np.array(found)


def test_drawn_ahead_it_is_the_same():
    plain, foreseen = danced(Drift(COUNT, 3), range(9), ahead=False), danced(Drift(COUNT, 3), range(9), ahead=True)
    assert np.array_equal(plain, foreseen)
    assert not np.array_equal(plain, danced(Drift(COUNT, 4), range(9), ahead=False))


def test_no_step_at_the_lines_and_never_farther_than_asked():
    found = danced(Drift(COUNT, 1), range(12), ahead=False).reshape(12, 9, COUNT)
    assert found[1:, 0] == pytest.approx(found[:-1, -1], abs=1e-9)
    assert 0.01 < np.abs(found).max() <= 0.1


def test_the_phase_goes_on_as_fast_as_the_frequencies_say():
    drift = Drift(COUNT, 2)
    before = drift.phase.copy()
    for measure in range(50):
        drift.begin_measure(measure)
    cycles = (drift.phase - before) / (2.0 * np.pi * 49)
    assert (cycles >= KNOT_LOW).all()
    assert (cycles <= KNOT_HIGH).all()


def test_every_purpose_and_measure_has_chances_of_its_own():
    drawn = [
        chance_of(seed, purpose, measure).uniform(size=3).tobytes()
        for seed in (1, 2)
        for purpose in Purpose
        for measure in (-1, 0, 1)
    ]
    assert len(set(drawn)) == len(drawn)
