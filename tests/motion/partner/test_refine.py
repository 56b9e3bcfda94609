"""Tests of refinement: the same sequence of units, with optimal boundaries at the rate of the input."""

import numpy as np
import numpy.typing as npt
import pytest

from live.motion.partner.decoder import Reading, decode
from live.motion.partner.point_clouds import Cloud, fit, gap, time_scaled
from live.motion.partner.refinement import refine
from live.motion.partner.time_scaled_units import make_stretches
from live.motion.partner.units import Units
from tests.motion.partner.made_examples import made_cloud, made_units

K = 0.5
Case = tuple[Units, Cloud, Reading]


@pytest.fixture(name="case", scope="module")
def _case() -> Case:
    units = made_units(21, 12, rate=30.0)
    x = made_cloud(np.random.default_rng(22), 181, 30.0)
    coarse = decode(x.resampled(7.5), make_stretches(units, 7.5, 0.15), k=K)
    return units, x, coarse


def test_units_are_kept_and_boundaries_stay_near(case: Case) -> None:
    units, x, coarse = case
    fine = refine(x, units, coarse, k=K, stretch=0.15)
    np.testing.assert_array_equal(fine.unit, coarse.unit)
    assert fine.start[0] == 0
    assert fine.start[-1] + fine.duration[-1] == x.count - 1
    np.testing.assert_array_equal(fine.start[1:], (fine.start + fine.duration)[:-1])
    assert np.abs(fine.start - 4 * coarse.start).max() <= 4
    assert np.abs(fine.duration[1:-1] / 30.0 - units.seconds[fine.unit][1:-1]).max() <= 0.15 + 1e-9


def test_score_is_sum_of_parts(case: Case) -> None:
    """D and C of the returned sequence, computed one by one in numpy."""
    units, x, coarse = case
    fine = refine(x, units, coarse, k=K, stretch=0.15)
    score, before = 0.0, None
    for unit, start, frames in zip(fine.unit.tolist(), fine.start.tolist(), fine.duration.tolist(), strict=True):
        of = units.examples[0]
        begin, length = float(units.start[unit]), float(units.length[unit])
        window = Cloud(x.floor[start : start + frames + 1], x.height[start : start + frames + 1], x.rate)
        one = fit(window, time_scaled(of.control, begin, length, frames))
        target = time_scaled(of.target, begin, length, frames).transformed(one.turn, one.shift)
        score += one.distance + (0.0 if before is None else 4.0 * K * gap(before, target))
        before = target
    assert fine.score == pytest.approx(score, rel=1e-9)


def test_moving_one_boundary_never_improves_score(case: Case) -> None:
    """The optimum of a search over all boundaries cannot be improved by moving a single one."""
    units, x, coarse = case
    fine = refine(x, units, coarse, k=K, stretch=0.15)
    edges = np.concatenate((fine.start, [x.count - 1]))

    def score_of(edges: npt.NDArray[np.int64]) -> float:
        total, before = 0.0, None
        for n, unit in enumerate(fine.unit.tolist()):
            of, start, stop = units.examples[0], int(edges[n]), int(edges[n + 1])
            window = Cloud(x.floor[start : stop + 1], x.height[start : stop + 1], x.rate)
            begin, length = float(units.start[unit]), float(units.length[unit])
            one = fit(window, time_scaled(of.control, begin, length, stop - start))
            target = time_scaled(of.target, begin, length, stop - start).transformed(one.turn, one.shift)
            total += one.distance + (0.0 if before is None else 4.0 * K * gap(before, target))
            before = target
        return total

    best = score_of(edges)
    for n in range(1, len(edges) - 1):
        for step in (-1, 1):
            other = edges.copy()
            other[n] += step
            seconds = np.diff(other)[[n - 1, n]] / 30.0
            legal = np.abs(seconds - units.seconds[fine.unit[[n - 1, n]]]) <= 0.15 + 1e-9
            if legal.all() and abs(other[n] - 4 * int(coarse.start[n])) <= 4:
                assert score_of(other) >= best - 1e-9


def test_boundaries_follow_known_beats(case: Case) -> None:
    units, x, coarse = case
    toll = np.where(np.arange(x.count) % 3 == 0, 0.0, np.inf)
    toll[-1] = 0.0
    fine = refine(x, units, coarse, k=K, stretch=0.15, boundary_cost=toll)
    assert (fine.start % 3 == 0).all()
