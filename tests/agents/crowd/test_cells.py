"""Grid cells contain every present agent once, also agents with non-finite positions."""

from itertools import chain, pairwise

import numpy as np
import pytest

from live.agents.crowd.spatial_grid_kernels import SORTED_ROWS, sort_agents

CAPACITY = 64


def sorted_by_cells(places):
    """The agents in each cell, as a list; `places` (A, 2) [m]."""
    count = len(places)
    state, wants = np.zeros(8 * count, np.float32), np.zeros(8 * count, np.float32)
    state[: 2 * count] = np.ravel(places)
    wants[7::8] = 1.0
    cells, grid = np.full((2, CAPACITY + 2), -1, np.int32), np.zeros(4)
    slots, scratch = np.full(count, -1, np.int32), np.zeros(2 * count, np.int32)
    found = sort_agents(
        state, wants, np.zeros(2 * count, np.float32), np.zeros((SORTED_ROWS, count), np.float32), slots, scratch,
        cells, grid,
    )  # fmt: skip
    assert found == count
    start = cells[0, : int(grid[2]) * int(grid[3]) + 1]
    assert start[0] == 0
    assert start[-1] == count
    assert np.all(np.diff(start) >= 0)
    return [slots[begin:end].tolist() for begin, end in pairwise(start)]


@pytest.mark.parametrize("strange", [np.nan, np.inf, -np.inf, 3e38, -3e38, 1e7], ids=str)
@pytest.mark.parametrize("many", [1, 5, 16])
def test_agent_with_non_finite_position_is_in_a_cell(strange, many):
    places = np.random.default_rng(3).uniform(-4.0, 4.0, (16, 2)).astype(np.float32)
    places[:many] = strange
    cells = sorted_by_cells(places)
    assert sorted(chain(*cells)) == list(range(16))
    places[:many, 1] = 0.5
    assert sorted(chain(*sorted_by_cells(places))) == list(range(16))


def test_nearby_agents_share_a_cell():
    cells = sorted_by_cells(np.array([[0.1, 0.1], [0.2, 0.1], [2.5, 0.1], [0.1, 3.5]]))
    assert [sorted(cell) for cell in cells if cell] == [[0, 1], [2], [3]]
