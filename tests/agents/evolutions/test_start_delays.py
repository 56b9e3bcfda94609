"""Clearance: CAPT, divide and conquer, and repaired ripples (T101, T147)."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents.evolutions import paths
from live.agents.evolutions.collision_check import Clearance, repair_in_pieces
from live.agents.evolutions.incremental_assignment import run_to_end
from live.agents.evolutions.paths import bend_paths_in_pieces
from live.agents.evolutions.slot_assignment import assign
from live.agents.evolutions.start_delays import Arrival, Ripple, StartOrder, delays, limit_delays, start_and_arrival
from live.agents.evolutions.trajectory import Locomotion


def approaches(locomotion, radius):
    """All pairs of dancers whose bodies would touch on these paths, the nearest first."""
    clearance = Clearance(locomotion, radius)
    clearance.compute_rows(0, locomotion.count)
    return clearance.approaches()


def scatter_points(count, spacing, chance, half=(7.0, 5.0)):
    found = []
    for _ in range(20_000):
        dart = chance.uniform(-1, 1, 2) * half
        if all(math.dist(dart, other) >= spacing for other in found):
            found.append(dart)
        if len(found) == count:
            break
    return np.array(found)


def straight_locomotion(start, goal, waits=None, end=8.0, arrive=Arrival.TOGETHER):
    own = start_and_arrival(0.0, end, np.zeros(len(start)) if waits is None else waits, arrive)
    return Locomotion(paths.straight_paths(start, goal), own, np.zeros((len(start), 1, 2)))


@given(st.integers(2, 30), st.floats(0.6, 1.2), st.integers(0, 10_000), st.floats(0, 0.5))
@settings(deadline=None, max_examples=40)
def test_capt_paths_keep_spacing_over_root_two(count, spacing, seed, soft):
    chance = np.random.default_rng(seed)
    start, goal = scatter_points(count, spacing, chance), scatter_points(count, spacing, chance)
    count = min(len(start), len(goal))
    start, goal = start[:count], goal[:count]
    moved = straight_locomotion(start, goal[assign(start, goal)])
    moved = Locomotion(moved.path_knots, moved.times, moved.turns, soft)
    clearance = Clearance(moved, 0.25)
    clearance.compute_rows(0, count)
    assert clearance.distance.min() >= spacing / math.sqrt(2) - 1e-4


def test_approaches_report_colliding_pair_and_beat():
    moved = straight_locomotion(np.array([[-2, 0], [2, 0], [0, 3]]), np.array([[2, 0], [-2, 0.1], [0, 3]]))
    found = approaches(moved, 0.25)
    assert [(a.first, a.second) for a in found] == [(0, 1)]
    assert found[0].beat == pytest.approx(4.0, abs=0.1)
    assert found[0].distance == pytest.approx(0.05, abs=0.01)
    assert approaches(moved, [0.02, 0.02, 0.25]) == []


@pytest.mark.parametrize("seed", range(3))
def test_divide_and_conquer_separates_dancers_that_swap_places(seed):
    angle = np.arange(10) * 2 * np.pi / 10
    ring = np.stack([np.sin(angle), np.cos(angle)], 1) * 3
    moved = straight_locomotion(ring, -ring)
    bent = run_to_end(bend_paths_in_pieces(moved, 0.54, seed=seed))
    assert len(approaches(moved, 0.25)) == 45  # all meet all in the middle: the hardest there is
    assert approaches(bent, 0.25) == []
    assert bent.path_knots[:, 0] == pytest.approx(ring, abs=1e-6)
    assert bent.path_knots[:, -1] == pytest.approx(-ring, abs=1e-6)
    assert (bent.path_knots == run_to_end(bend_paths_in_pieces(moved, 0.54, seed=seed)).path_knots).all()
    inside = run_to_end(bend_paths_in_pieces(moved, 0.54, seed=seed, half=(3.1, 3.1)))
    assert np.abs(inside.path_knots).max() <= 3.1 + 1e-6


@pytest.mark.parametrize("arrive", [Arrival.APART, Arrival.TOGETHER])
def test_ripple_is_repaired_with_few_retimed_dancers(arrive):
    chance = np.random.default_rng(5)
    met = changed = 0
    for seed in range(8):
        start, goal = scatter_points(40, 0.75, chance), scatter_points(40, 0.75, chance)
        moved_to = goal[assign(start, goal)]
        waits = delays(Ripple(6.0, StartOrder.RANDOM), start, np.arange(40), seed=seed)
        rippled = straight_locomotion(start, moved_to, waits, arrive=arrive)
        met += len(approaches(rippled, 0.25))
        result = run_to_end(repair_in_pieces(rippled, 0.25, waits, begin=0.0, end=8.0, arrive=arrive))
        assert result.remaining == ()
        assert approaches(result.locomotion, 0.25) == []
        assert result.locomotion.times[:, 1].max() <= 8.0 + 1e-9
        assert result.locomotion.times[:, 0].min() >= 0.0
        changed += result.retimed
    assert met > 0
    assert 0 < changed < 80


def test_unresolved_collisions_are_reported():
    moved = straight_locomotion(np.array([[0, 0], [0.1, 0]]), np.array([[3, 0], [3.1, 0]]))
    result = run_to_end(repair_in_pieces(moved, 0.25, np.zeros(2), begin=0.0, end=8.0))
    assert [(a.first, a.second) for a in result.remaining] == [(0, 1)]


@given(
    st.integers(1, 20), st.floats(0, 8), st.sampled_from(StartOrder), st.sampled_from(Arrival), st.integers(0, 999),
    st.floats(0.5, 16),
)  # fmt: skip
def test_delays_keep_range_and_arrival_time(count, beats, order, arrive, seed, end):
    start = np.random.default_rng(seed).uniform(-5, 5, (count, 2))
    waits = delays(Ripple(beats, order, arrive), start, np.arange(count), seed=seed)
    assert waits.min() == 0.0
    if order in (StartOrder.CENTRE, StartOrder.OUTSIDE):  # two are equally far from the middle
        assert waits.max() == pytest.approx(beats) or (count <= 2 and waits.max() == 0.0)
    else:
        assert waits.max() == pytest.approx(beats if count > 1 else 0.0)
    own = start_and_arrival(0.0, end, limit_delays(waits, end), arrive)
    assert (own[:, 1] - own[:, 0] >= 0.25 * end - 1e-9).all()
    assert own[:, 1].max() == pytest.approx(end)
    assert own[:, 0].min() == 0.0
    if arrive is Arrival.TOGETHER:
        assert (own[:, 1] == end).all()
    else:
        assert np.ptp(own[:, 1] - own[:, 0]) < 1e-9


def test_start_orders_give_expected_delays():
    start = np.array([[-2, 1], [3, 0], [0, -1], [0, 3.0]])
    wait = lambda order: delays(Ripple(2.0, order), start, np.arange(4)).tolist()  # noqa: E731
    assert wait(StartOrder.LEFT) == [0, 2, 1, 1]  # the same x: together
    assert wait(StartOrder.RIGHT) == [2, 0, 1, 1]
    assert wait(StartOrder.FRONT) == pytest.approx([2 / 3, 4 / 3, 2, 0])
    assert wait(StartOrder.BACK) == pytest.approx([4 / 3, 2 / 3, 0, 2])
    assert wait(StartOrder.ID) == pytest.approx([0, 2 / 3, 4 / 3, 2])
    assert np.argsort(wait(StartOrder.CENTRE)).tolist() == np.argsort(np.hypot(*(start - start.mean(0)).T)).tolist()
    assert wait(StartOrder.OUTSIDE) == pytest.approx([2 - w for w in wait(StartOrder.CENTRE)])
    one = delays(Ripple(2.0, StartOrder.RANDOM), start[1:], np.arange(1, 4), seed=3)
    assert np.argsort(one).tolist() == [
        n for n in np.argsort(delays(Ripple(2.0, StartOrder.RANDOM), start, np.arange(4), seed=3)) - 1 if n >= 0
    ]
