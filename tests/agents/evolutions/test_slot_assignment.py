"""Slot assignment: optimal, a permutation, within sections, incremental (T097-T100; CAPT)."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents.evolutions import incremental_assignment
from live.agents.evolutions.evolution_kernels import swap_pairs
from live.agents.evolutions.incremental_assignment import MAX_URGENT_PAIRS, PAIRS_PER_PIECE, IncrementalAssignment
from live.agents.evolutions.slot_assignment import Cost, Fill, assign, by_id, distances, sections


def places(count, seed, size=5.0):
    return np.random.default_rng(seed).uniform(-size, size, (count, 2))


def all_assignments(dancers, slots):
    """All ways to give as many dancers as possible a slot."""
    if dancers <= slots:
        return itertools.permutations(range(slots), dancers)
    return (
        tuple(row.get(d, -1) for d in range(dancers))
        for who in itertools.permutations(range(dancers), slots)
        for row in [dict(zip(who, range(slots), strict=True))]
    )


def assignment_cost(cost, metres, slot, mean=0.0, weight=0.5):
    way = np.array([metres[d, s] for d, s in enumerate(slot) if s >= 0])
    return {
        Cost.SQUARED: (way**2).sum(),
        Cost.SHORTEST: way.sum(),
        Cost.EQUAL: abs(way - mean).sum(),
        Cost.BOTH: ((1 - weight) * way + weight * abs(way - mean)).sum(),
        Cost.BOTTLENECK: way.max(initial=0.0),
    }[cost]


@pytest.mark.parametrize("cost", list(Cost))
@pytest.mark.parametrize(("dancers", "slots"), [(5, 5), (3, 6), (6, 3), (1, 1)])
def test_assignment_has_minimum_cost(cost, dancers, slots):
    """Against brute force; the mean of W_equal is that of the shortest matching (two passes, T099)."""
    for seed in range(4):
        start, goal = places(dancers, seed), places(slots, seed + 100)
        metres = distances(start, goal)
        ways = list(all_assignments(dancers, slots))
        shortest = min(ways, key=lambda slot: assignment_cost(Cost.SHORTEST, metres, slot))
        mean = assignment_cost(Cost.SHORTEST, metres, shortest) / min(dancers, slots)
        best = min(assignment_cost(cost, metres, slot, mean) for slot in ways)
        assert assignment_cost(cost, metres, assign(start, goal, cost=cost), mean) == pytest.approx(best, abs=1e-9)


@given(st.integers(0, 9), st.integers(0, 9), st.sampled_from(Cost), st.sampled_from(Fill), st.integers(0, 1000))
@settings(deadline=None)
def test_assignment_is_injective_and_maximal(dancers, slots, cost, fill, seed):
    slot = assign(places(dancers, seed), places(slots, seed + 1).reshape(-1, 2), cost=cost, fill=fill)
    taken = slot[slot >= 0]
    assert slot.shape == (dancers,)
    assert len(taken) == len(set(taken)) == min(dancers, slots)
    if fill is Fill.IN_ORDER and dancers < slots:
        assert sorted(taken) == list(range(dancers))


@given(st.integers(1, 8), st.integers(1, 8), st.integers(0, 1000))
@settings(deadline=None)
def test_restricted_assignment_is_allowed_and_maximum(dancers, slots, seed):
    possible = np.random.default_rng(seed).random((dancers, slots)) < 0.4
    slot = assign(places(dancers, seed), places(slots, seed + 1), allowed=possible)
    assert all(possible[d, s] for d, s in enumerate(slot) if s >= 0)
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import maximum_bipartite_matching

    most = (maximum_bipartite_matching(csr_matrix(possible)) >= 0).sum()
    assert (slot >= 0).sum() == most


@given(st.integers(2, 30), st.integers(0, 1000))
@settings(deadline=None, max_examples=30)
def test_assignment_is_independent_of_dancer_order(count, seed):
    start, goal = places(count, seed), places(count, seed + 1)
    mixed = np.random.default_rng(seed).permutation(count)
    assert (assign(start[mixed], goal) == assign(start, goal)[mixed]).all()


def test_assignment_by_id_follows_declared_order():
    assert by_id(3, 5).tolist() == [0, 1, 2]
    assert by_id(4, 2).tolist() == [0, 1, -1, -1]


def test_sections_keep_their_slots_and_overflow_onto_unmarked_slots():
    words = [{"soloist"}, set(), {"red"}, {"red"}, {"red", "soloist"}, set()]
    dancer, slot = sections(words, ["", "soloist", "red", "", "red", ""])
    assert dancer.tolist() == [1, 0, 2, 2, 1, 0]
    assert slot.tolist() == [0, 1, 2, 0, 2, 0]


@given(st.integers(0, 60), st.integers(0, 60), st.integers(0, 500))
@settings(deadline=None, max_examples=40)
def test_incremental_assignment_keeps_sections(dancers, slots, seed):
    chance = np.random.default_rng(seed)
    dancer, slot = chance.integers(0, 3, dancers).astype(np.int32), chance.integers(0, 3, slots).astype(np.int32)
    matching = IncrementalAssignment()
    matching.begin(
        places(dancers, seed).reshape(-1, 2), places(slots, seed + 1).reshape(-1, 2), dancer_section=dancer,
        slot_section=slot, exact=8,
    )  # fmt: skip
    found = matching.finish()
    taken = found[found >= 0]
    assert len(taken) == len(set(taken))
    assert all(slot[s] in (0, dancer[d]) for d, s in enumerate(found) if s >= 0)
    own = sum(min((dancer == s).sum(), (slot == s).sum()) for s in (1, 2))
    rest = sum(max((dancer == s).sum() - (slot == s).sum(), 0) for s in (1, 2)) + (dancer == 0).sum()
    assert len(taken) == own + min(rest, (slot == 0).sum())


@pytest.mark.parametrize("count", [129, 400, 1001])
def test_incremental_assignment_of_hundreds_has_no_improving_swap(count):
    start, goal = places(count, 1, 20.0), places(count, 2, 20.0)
    matching = IncrementalAssignment()
    matching.begin(start, goal)
    pieces = 0
    while not matching.done:
        matching.work()
        pieces += 1
    slot = matching.slot
    assert sorted(slot) == list(range(count))
    assert pieces > 8
    gain = (start[:, None] - start[None]) * (goal[slot][:, None] - goal[slot][None])
    assert gain.sum(axis=2).min() > -1e-6  # the condition of CAPT, for every pair
    exact = ((start - goal[assign(start, goal)]) ** 2).sum()
    assert ((start - goal[slot]) ** 2).sum() < 1.35 * exact


@pytest.mark.parametrize(("dancers", "slots"), [(300, 200), (200, 300)])
@pytest.mark.parametrize("fill", list(Fill))
def test_incremental_assignment_handles_unequal_counts(dancers, slots, fill):
    matching = IncrementalAssignment()
    matching.begin(places(dancers, 1, 9.0), places(slots, 2, 9.0), fill=fill)
    taken = [s for s in matching.finish() if s >= 0]
    assert len(taken) == len(set(taken)) == 200
    if fill is Fill.IN_ORDER and dancers < slots:
        assert sorted(taken) == list(range(200))


@pytest.mark.parametrize(("count", "complete"), [(300, True), (5000, False)])
def test_assignment_in_a_hurry_gives_every_dancer_a_place_within_little_work(count, complete, monkeypatch):
    examined = []

    def counted(start, slots, slot, section, first, last):
        examined.append(sum(len(start) - row for row in range(first, last)))
        return swap_pairs(start, slots, slot, section, first, last)

    monkeypatch.setattr(incremental_assignment, "swap_pairs", counted)
    start, goal = places(count, 1, 60.0), places(count, 2, 60.0)
    matching = IncrementalAssignment()
    matching.begin(start, goal)
    matching.hurry()
    slot = matching.finish()
    assert sorted(slot) == list(range(count))
    assert sum(examined) < MAX_URGENT_PAIRS + 2 * PAIRS_PER_PIECE
    way = np.hypot(*(start - goal[slot]).T).mean()
    assert way < 0.25 * np.hypot(*(start - goal).T).mean()  # halving alone brings dancers to places near them
    gain = (start[:400, None] - start[None]) * (goal[slot][:400, None] - goal[slot][None])
    assert (gain.sum(axis=2).min() > -1e-6) == complete
