"""Yielding agents against a plain graph search."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents.goals.goals import yielding_agents


def reachable(position, arrived, near):
    """Arrived agents reachable from agents still moving, through steps of at most `near`."""
    found = set(map(int, np.flatnonzero(~arrived)))
    waiting = list(found)
    while waiting:
        here = position[waiting.pop()]
        for other in map(int, np.flatnonzero(np.linalg.norm(position - here, axis=1) <= near)):
            if other not in found:
                found.add(other)
                waiting.append(other)
    return np.array([agent in found and arrived[agent] for agent in range(len(arrived))], bool)


@given(st.integers(0, 2**31 - 1), st.integers(0, 30), st.floats(0.0, 1.0))
@settings(max_examples=100, deadline=None)
def test_yielding_agents_are_those_reachable_from_moving_agents(seed, count, share):
    chance = np.random.default_rng(seed)
    position = chance.uniform(0, 4, (count, 2))
    arrived = chance.uniform(size=count) < share
    expected = reachable(position, arrived, 0.7)
    np.testing.assert_array_equal(yielding_agents(position, arrived, 0.7), expected)


def test_isolated_or_settled_agents_do_not_yield():
    row = np.array([[0, 0], [0.6, 0], [1.2, 0], [5, 0]])
    arrived = np.array([False, True, True, True])
    assert list(yielding_agents(row, arrived, 0.7)) == [False, True, True, False]
    assert not yielding_agents(row, np.ones(4, bool), 0.7).any()
    assert not yielding_agents(row, np.zeros(4, bool), 0.7).any()
