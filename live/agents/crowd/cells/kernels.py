"""Cells: the agents who are present, sorted by square cells, as rows of numbers (structure of arrays).

A counting sort every tick (survey of the steering peers: 6 ns an agent). The cells of a row lie one after another, so
that the 3 x 3 cells round one are three stretches of slots.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

NEIGHBOUR_RANGE = 3.0
"""Metres within which neighbours matter; the size of the cells."""

# rows of the sorted agents
X, Z, VX, VZ, RADIUS, GIVE, SORTED_ROWS = 0, 1, 2, 3, 4, 5, 6
_PRESENCE = 7  # column of Wants.rows
_LIMIT = 1e6
_ONE: Any = np.float32(1.0)
_TWO: Any = np.float32(2.0)
_BRISK2: Any = np.float32(0.7**2)
_SLOWEST2: Any = np.float32(0.01)
_IDLE_GIVES: Any = np.float32(0.9)


@kernel("i8(f4[::1], f4[:,::1], i4[::1], f8[::1], i8)")
def _lay_grid(state: Float32, wants: Float32, order: Int32, grid: Any, capacity: int) -> int:
    """Lay the grid over those present, at most `capacity` cells; `order` holds them first, in their order: returns n.

    grid (4,): x and z of its corner [m], columns, rows. If they stand so far apart that there would be too many cells,
    it covers the middle, and all outside belong to the cells of its edge: neighbours stay in neighbouring cells.
    """
    left, right, back, front = _LIMIT, -_LIMIT, _LIMIT, -_LIMIT
    n = 0
    for i in range(wants.shape[0]):
        if wants[i, _PRESENCE] > 0.0:
            x, z = float(state[2 * i]), float(state[2 * i + 1])
            left, right, back, front = min(left, x), max(right, x), min(back, z), max(front, z)
            order[n] = i
            n += 1
    if n == 0:
        left, right, back, front = 0.0, 0.0, 0.0, 0.0
    columns = math.floor((right - left) / NEIGHBOUR_RANGE) + 1.0
    rows = math.floor((front - back) / NEIGHBOUR_RANGE) + 1.0
    if columns * rows > capacity:
        side = math.floor(math.sqrt(float(capacity)))
        if columns <= side:
            rows = math.floor(capacity / columns)
        elif rows <= side:
            columns = math.floor(capacity / rows)
        else:
            columns, rows = side, side
    grid[0] = 0.5 * (left + right) - 0.5 * columns * NEIGHBOUR_RANGE
    grid[1] = 0.5 * (back + front) - 0.5 * rows * NEIGHBOUR_RANGE
    grid[2], grid[3] = columns, rows
    return n


@kernel("i8(f4[::1], f4[:,::1], f4[:,::1], f4[:,::1], i4[::1], i4[::1], i4[::1], f8[::1])")
def sort_agents(
    state: Float32,
    wants: Float32,
    model: Float32,
    sorted_: Float32,
    slot_agent: Int32,
    cell_of: Int32,
    start: Int32,
    grid: Any,
) -> int:
    """Sort those present into cells; returns how many (n).

    Slots start[c]:start[c + 1] are cell c's agents in the order of their numbers; slot_agent (A,) holds the numbers,
    sorted_ (SORTED_ROWS, >= A) their values, cell_of (2 A,) is scratch. grid (4,): x, z of the corner, columns, rows.
    """
    a = wants.shape[0]
    n = _lay_grid(state, wants, cell_of, grid, start.shape[0] - 2)
    columns, rows = int(grid[2]), int(grid[3])
    x0, z0, scale = np.float32(grid[0]), np.float32(grid[1]), np.float32(1.0 / NEIGHBOUR_RANGE)
    for c in range(columns * rows + 2):
        start[c] = 0
    last_column, last_row, zero = np.float32(columns - 1), np.float32(rows - 1), np.float32(0.0)
    for k in range(n):
        i = cell_of[k]
        column = np.int32(min(max((state[2 * i] - x0) * scale, zero), last_column))
        row = np.int32(min(max((state[2 * i + 1] - z0) * scale, zero), last_row))
        cell_of[a + k] = row * np.int32(columns) + column
        start[cell_of[a + k] + 2] += 1
    for c in range(1, columns * rows):
        start[c + 2] += start[c + 1]
    for k in range(n):
        i, c = cell_of[k], cell_of[a + k]
        s = start[c + 1]
        start[c + 1] = s + 1
        slot_agent[s] = i
        sorted_[X, s], sorted_[Z, s] = state[2 * i], state[2 * i + 1]
        sorted_[VX, s], sorted_[VZ, s] = state[2 * a + 2 * i], state[2 * a + 2 * i + 1]
        wish2, speed = wants[i, 0] * wants[i, 0] + wants[i, 1] * wants[i, 1], wants[i, 2]
        idle = max(_ONE - wish2 / max(_BRISK2 * speed * speed, _SLOWEST2), zero)
        sorted_[RADIUS, s] = model[i, 0]
        sorted_[GIVE, s] = _TWO - model[i, 1] * (_ONE + _IDLE_GIVES * idle)
    return n
