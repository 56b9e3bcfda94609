"""Spatial grid: the present agents sorted by cell, as rows of numbers (structure of arrays).

A counting sort every tick (survey of the steering peers: 6 ns an agent). The cells of a row are consecutive, so the
neighbourhood of a cell is a few contiguous ranges of slots.

Blocks: LANES consecutive agents of a row of cells, as vector lanes. A block is one array with rows of LANES, so that
the compiler can tell the rows apart; loops over lanes have no branches or checks. The last lanes may belong to the next
row of cells or to no agent; their results are overwritten or never read.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

NEIGHBOUR_RANGE = 3.0
"""Range of neighbour interaction [m]."""
CELL_X, CELL_Z = 1.0, 3.0
"""Size of a cell [m]."""
COLUMN_REACH, ROW_REACH = 3, 1
"""Columns and rows of cells on each side that contain all neighbours."""

# rows of the sorted agents
X, Z, VX, VZ, RADIUS, MOBILITY, SORTED_ROWS = 0, 1, 2, 3, 4, 5, 6
_PRESENCE = 7  # column of Wants.rows
SLEEP_TIME = 0.5
"""Time [s] without motion after which an agent sleeps."""
_LIMIT = 1e6
_NEXT: Any = np.uint64(1)
_ZERO: Any = np.float32(0.0)
_ONE: Any = np.float32(1.0)
_TWO: Any = np.float32(2.0)
_PER_X: Any = np.float32(1.0 / CELL_X)
_PER_Z: Any = np.float32(1.0 / CELL_Z)
_BRISK2: Any = np.float32(0.7**2)
_SLOWEST2: Any = np.float32(0.01)
_IDLE_MOBILITY: Any = np.float32(0.9)
"""Extra share of avoidance taken by an agent without a command: at its goal it lets others pass."""


@inline_kernel
def neighbour_command_key(separation: Any, cohesion: Any) -> Any:
    """Return a number that identifies the neighbour commands of a standing agent; a change wakes it."""
    return separation + np.float32(1000.0) * cohesion


@kernel("i8(f4[::1], f4[::1], i4[::1], f8[::1], i8)")
def _fit_grid(state: Float32, commands: Float32, order: Int32, grid: Any, capacity: int) -> int:
    """Lay the grid over the present agents, at most `capacity` cells; return their number n, `order` lists them first.

    grid (4,): x and z of its corner [m], columns, rows. If the agents are too far apart for the capacity, the grid
    covers the middle, and agents outside belong to its border cells; neighbours stay in neighbouring cells.
    """
    left, right, back, front = _LIMIT, -_LIMIT, _LIMIT, -_LIMIT
    n = 0
    for i in range(commands.shape[0] // 8):
        if commands[8 * i + _PRESENCE] > 0.0:
            x, z = float(state[2 * i]), float(state[2 * i + 1])
            left, right, back, front = min(left, x), max(right, x), min(back, z), max(front, z)
            order[n] = i
            n += 1
    if not (left <= right and back <= front):  # no agent, or none with a finite position
        left, right, back, front = 0.0, 0.0, 0.0, 0.0
    columns = math.floor((right - left) / CELL_X) + 1.0
    rows = math.floor((front - back) / CELL_Z) + 1.0
    if columns * rows > capacity:
        side = math.floor(math.sqrt(float(capacity)))
        if columns <= side:
            rows = math.floor(capacity / columns)
        elif rows <= side:
            columns = math.floor(capacity / rows)
        else:
            columns, rows = side, side
    grid[0] = 0.5 * (left + right) - 0.5 * columns * CELL_X
    grid[1] = 0.5 * (back + front) - 0.5 * rows * CELL_Z
    grid[2], grid[3] = columns, rows
    return n


@inline_kernel
def _is_awake(state: Float32, commands: Float32, i: int, a: int) -> Any:
    """Return 1 for an awake agent, 0 for a sleeping one: no command, and no motion for SLEEP_TIME seconds."""
    wish = commands[8 * i] * commands[8 * i] + commands[8 * i + 1] * commands[8 * i + 1]
    asked = neighbour_command_key(commands[8 * i + 3], commands[8 * i + 5])
    asleep = state[6 * a + i] >= np.float32(SLEEP_TIME) and wish <= np.float32(0.0) and state[7 * a + i] == asked
    return np.int32(0) if asleep else np.int32(1)


@inline_kernel
def _find_cells(state: Float32, cell_of: Int32, grid: Any, a: int) -> None:
    """Write the cells of all agents, absent ones included, into cell_of[a:]; branch-free, so that it is vectorised.

    An agent with a NaN position belongs to the first cell: `max` then returns its first argument.
    """
    x0, z0 = np.float32(grid[0]), np.float32(grid[1])
    last_column, last_row = np.float32(grid[2] - 1.0), np.float32(grid[3] - 1.0)
    columns = np.int32(grid[2])
    for i in range(a):
        column = np.int32(min(max(_ZERO, (state[2 * i] - x0) * _PER_X), last_column))
        row = np.int32(min(max(_ZERO, (state[2 * i + 1] - z0) * _PER_Z), last_row))
        cell_of[a + i] = np.int32(row * columns) + column


@inline_kernel
def _count_awake(
    state: Float32, commands: Float32, cell_of: Int32, start: Int32, awake: Int32, n: int, cell_count: int
) -> None:
    """Count the awake agents in the preceding cells; returns early if no agent rests, the usual case."""
    a = commands.shape[0] // 8
    resting: Any = np.int32(0)
    for i in range(a):
        resting = np.int32(resting | np.int32(state[6 * a + i] >= np.float32(SLEEP_TIME)))
    for c in range(cell_count + 1):
        awake[c] = 0 if resting != 0 else start[c + 1]
    if resting != 0:
        for k in range(n):
            i = cell_of[k]
            awake[cell_of[a + i] + 1] += _is_awake(state, commands, i, a)
        for c in range(1, cell_count):
            awake[c + 1] += awake[c]


@inline_kernel
def _copy_agents(
    state: Float32, commands: Float32, model: Float32, slot_agent: Int32, sorted_: Float32, n: int
) -> None:
    """Copy the agents' data in slot order; unsigned indices avoid the check for negative ones."""
    velocity = np.uint64(2 * (commands.shape[0] // 8))
    for s in range(n):
        two, eight = np.uint64(2 * slot_agent[s]), np.uint64(8 * slot_agent[s])
        sorted_[X, s], sorted_[Z, s] = state[two], state[two + _NEXT]
        sorted_[VX, s], sorted_[VZ, s] = state[velocity + two], state[velocity + two + _NEXT]
        wish2 = commands[eight] * commands[eight] + commands[eight + _NEXT] * commands[eight + _NEXT]
        speed = commands[eight + _NEXT + _NEXT]
        idle = max(_ONE - wish2 / max(_BRISK2 * speed * speed, _SLOWEST2), _ZERO)
        sorted_[RADIUS, s] = model[two]
        sorted_[MOBILITY, s] = _TWO - model[two + _NEXT] * (_ONE + _IDLE_MOBILITY * idle)


@kernel("i8(f4[::1], f4[::1], f4[::1], f4[:,::1], i4[::1], i4[::1], i4[:,::1], f8[::1])")
def sort_agents(
    state: Float32,
    commands: Float32,
    model: Float32,
    sorted_: Float32,
    slot_agent: Int32,
    cell_of: Int32,
    cells: Int32,
    grid: Any,
) -> int:
    """Sort the present agents into cells; return their number n.

    Slots start[c]:start[c + 1] are the agents of cell c in ascending order, start = cells[0]; cells[1, c] is the number
    of awake agents in the cells before c. slot_agent (A,) receives the agent indices, sorted_ (SORTED_ROWS, >= A) the
    values; cell_of (2 A,) is scratch. state (8 A,), wants (8 A,), model (2 A,). grid (4,): x, z of the corner, columns,
    rows.
    """
    a = commands.shape[0] // 8
    start, awake = cells[0], cells[1]
    n = _fit_grid(state, commands, cell_of, grid, start.shape[0] - 2)
    cell_count = int(grid[2]) * int(grid[3])
    for c in range(cell_count + 2):
        start[c] = 0
    _find_cells(state, cell_of, grid, a)
    for k in range(n):
        start[np.uint64(cell_of[np.uint64(a) + np.uint64(cell_of[k])] + 2)] += 1
    for c in range(1, cell_count):
        start[c + 2] += start[c + 1]
    _count_awake(state, commands, cell_of, start, awake, n, cell_count)
    for k in range(n):
        i: Any = np.uint64(cell_of[k])
        c_next: Any = np.uint64(cell_of[np.uint64(a) + i] + 1)
        s = start[c_next]
        start[c_next] = s + 1
        slot_agent[np.uint64(s)] = i
    _copy_agents(state, commands, model, slot_agent, sorted_, n)
    return n


LANES = 8

# rows of an agent's request to the neighbour pass
PER_SEPARATION2, PER_HORIZON, ALIGNMENT, COHESION, PERSONAL, REQUEST_ROWS = 0, 1, 2, 3, 4, 5

# rows of the sums of an agent
PUSH_X, PUSH_Z = 0, 1
"""Vectors from the neighbours [m], weighted with (1 - d² / separation²)²."""
WEIGHT, FLOCK_X, FLOCK_Z = 2, 3, 4
"""Sum of weights (1 - d² / range²)², and with these weights: alignment x relative velocity + cohesion x vector to the
neighbour.
"""
AVOID_X, AVOID_Z = 5, 6
"""Acceleration that avoids predicted collisions [m/s²]."""
SUM_ROWS = 7

# rows of a block: X to RADIUS, the lane number, the requests, the sums
LANE, REQUESTS, SUMS, BLOCK_ROWS = 5, 6, 11, 18

_RANGE2: Any = np.float32(NEIGHBOUR_RANGE**2 * 1.0001)
_1, _2, _3, _4, _5, _6, _7 = (np.uint64(j) for j in range(1, LANES))  # unsigned: no check for negative indices


@inline_kernel
def all_sleep(awake: Int32, columns: int, rows: int, row: int, first: int, last: int) -> bool:
    """Whether all agents within range of columns first to last of `row` sleep."""
    left, right = max(first - COLUMN_REACH, 0), min(last + COLUMN_REACH + 1, columns)
    count = 0
    for r in range(max(row - ROW_REACH, 0), min(row + ROW_REACH + 1, rows)):
        count += awake[r * columns + right] - awake[r * columns + left]
    return count == 0


@inline_kernel
def zero_sleeping_sums(
    sums: Float32,
    start: Int32,
    awake: Int32,
    columns: int,
    rows: int,
    row: int,
    first_column: int,
    last_column: int,
    first: int,
    last: int,
) -> None:
    """Zero the sums of agents in slots first:last whose neighbourhood sleeps."""
    for c in range(first_column, last_column + 1):
        if all_sleep(awake, columns, rows, row, c, c):
            for i in range(max(start[row * columns + c], first), min(start[row * columns + c + 1], last)):
                for f in range(SUM_ROWS):
                    sums[f, i] = _ZERO


@inline_kernel
def find_candidates(
    sorted_: Float32,
    start: Int32,
    columns: int,
    rows: int,
    row: int,
    first_column: int,
    last_column: int,
    first: int,
    last: int,
    near: Int32,
    hits: Int32,
) -> int:
    """Write the candidates within range of the bounding box of slots first:last, in these columns, into `near`; return
    their number.
    """
    x0, x1, z0, z1 = sorted_[X, first], sorted_[X, first], sorted_[Z, first], sorted_[Z, first]
    for s in range(first + 1, last):
        x0, x1 = min(x0, sorted_[X, s]), max(x1, sorted_[X, s])
        z0, z1 = min(z0, sorted_[Z, s]), max(z1, sorted_[Z, s])
    left, right = max(first_column - COLUMN_REACH, 0), min(last_column + COLUMN_REACH + 1, columns)
    count = 0
    for r in range(max(row - ROW_REACH, 0), min(row + ROW_REACH + 1, rows)):
        begin, end = start[r * columns + left], start[r * columns + right]
        for t in range(end - begin):
            k: Any = np.uint64(begin + t)
            dx = max(max(x0 - sorted_[X, k], sorted_[X, k] - x1), _ZERO)
            dz = max(max(z0 - sorted_[Z, k], sorted_[Z, k] - z1), _ZERO)
            hits[t] = np.int32(dx * dx + dz * dz < _RANGE2)
        for t in range(end - begin):
            near[count] = begin + t
            count += hits[t]
    return count


@inline_kernel
def copy_lanes(source: Float32, f: int, first: int, to: Float32, g: int, begin: int) -> None:
    """Copy LANES numbers of row f from `first` on to row g from `begin` on; all are read first, in one load."""
    s: Any = np.uint64(first)
    t: Any = np.uint64(begin)
    a0, a1, a2, a3 = source[f, s], source[f, s + _1], source[f, s + _2], source[f, s + _3]
    a4, a5, a6, a7 = source[f, s + _4], source[f, s + _5], source[f, s + _6], source[f, s + _7]
    to[g, t], to[g, t + _1], to[g, t + _2], to[g, t + _3] = a0, a1, a2, a3
    to[g, t + _4], to[g, t + _5], to[g, t + _6], to[g, t + _7] = a4, a5, a6, a7


@inline_kernel
def fill_block(sorted_: Float32, requests: Float32, first: int, block: Float32) -> None:
    """Fill a block with the agents from slot `first` on and zero sums."""
    for f in range(5):
        copy_lanes(sorted_, f, first, block, f, 0)
    for f in range(REQUEST_ROWS):
        copy_lanes(requests, f, first, block, REQUESTS + f, 0)
    for f in range(SUM_ROWS):
        for j in range(LANES):
            block[SUMS + f, j] = _ZERO
