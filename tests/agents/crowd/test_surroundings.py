"""Surroundings: walls and obstacles by name, with bounded capacity, without exceptions."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents.crowd.contact_kernels import CAPACITY
from live.agents.crowd.obstacles import Surroundings


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 8), st.booleans(), st.floats(-50, 50)), max_size=60))
def test_obstacle_rows_match_a_dictionary(edits):
    surroundings, expected = Surroundings(), {}
    for number, puts, x in edits:
        name = str(number)
        if puts:
            assert surroundings.set_obstacle(name, x, 1.0, 0.5, vx=2.0)
            expected[name] = np.float32(x)
        else:
            assert surroundings.remove(name) == (expected.pop(name, None) is not None)
    rows = surroundings.obstacles[: surroundings.obstacle_count]
    assert dict(zip(surroundings.obstacle_names, rows[:, 0], strict=True)) == expected


def test_excess_and_invalid_entries_are_counted_and_refused():
    surroundings = Surroundings()
    for number in range(CAPACITY):
        assert surroundings.set_wall(str(number), 0, 0, 1, 1)
    assert not surroundings.set_wall("one more", 0, 0, 1, 1)
    assert surroundings.set_wall("3", 5, 5, 6, 6)  # one that stands there can be moved
    assert not surroundings.set_obstacle("a", float("nan"), 0, 1)
    assert not surroundings.set_obstacle("a", 0, 0, -1)
    assert not surroundings.set_obstacle("a", 1e30, 0, 1)
    assert surroundings.refused_count == 4
    assert surroundings.obstacle_count == 0
    assert surroundings.walls[3].tolist() == [5, 5, 6, 6]


def test_obstacle_array_is_reused_after_changes():
    surroundings = Surroundings()
    rows = surroundings.obstacles
    surroundings.set_obstacle("a", 0, 0, 1)
    surroundings.remove("a")
    surroundings.set_obstacle("b", 2, 0, 1)
    assert surroundings.obstacles is rows
