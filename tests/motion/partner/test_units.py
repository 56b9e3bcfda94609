"""Tests of unit clusters: units of a cluster are within the threshold, and one unit of each is kept."""

import numpy as np
import pytest

from live.motion.partner.point_clouds import fit, time_scaled
from live.motion.partner.units import COMPARISON_STEPS, Example, Units, cut_units, remove_duplicates, unit_distances
from tests.motion.partner.made_examples import made_cloud, made_units, standing


def test_unit_distances_equal_fit_distances() -> None:
    units = made_units(31, 5)
    found = unit_distances(units)
    of = units.examples[0]
    for one in range(5):
        for other in range(5):
            x, y = (time_scaled(of.control, units.start[n], units.length[n], COMPARISON_STEPS) for n in (one, other))
            motion = fit(x, y)
            mine, its = (
                time_scaled(of.target, units.start[n], units.length[n], COMPARISON_STEPS) for n in (one, other)
            )
            its = its.transformed(motion.turn, motion.shift)
            square = (
                motion.distance + (np.abs(mine.floor - its.floor) ** 2).sum() + ((mine.height - its.height) ** 2).sum()
            )
            assert found[one, other] == pytest.approx(np.sqrt(square / (8 * (COMPARISON_STEPS + 1))), abs=1e-9)


def _duplicated_units(seed: int) -> Units:
    """Ten units, each of them twice: the second time turned and moved."""
    chance = np.random.default_rng(seed)
    control, target = made_cloud(chance, 500, 60.0), made_cloud(chance, 500, 60.0)
    cuts = np.arange(0.0, 451.0, 45.0)
    examples = [
        Example("a", control, target, standing(500, 60.0), cuts, np.zeros(0)),
        Example("b", control.transformed(1j, 3.0), target.transformed(1j, 3.0), standing(500, 60.0), cuts, np.zeros(0)),
    ]
    return cut_units(examples)


def test_duplicate_units_are_kept_once_for_any_seed() -> None:
    units = _duplicated_units(32)
    assert units.count == 20
    kept = [remove_duplicates(units, 0.01, seed=seed) for seed in range(4)]
    for one in kept:
        assert one.count == 10
        np.testing.assert_allclose(np.sort(one.start), np.arange(10) * 45.0)
    assert len({tuple(one.example.tolist()) for one in kept}) > 1  # the seed decides which
    assert kept[0].example.tolist() == remove_duplicates(units, 0.01, seed=0).example.tolist()


def test_zero_threshold_keeps_all_units_and_large_keeps_one() -> None:
    units = _duplicated_units(33)
    assert remove_duplicates(units, 0.0, seed=0).count == 20
    assert remove_duplicates(units, 100.0, seed=0).count == 1
