"""Blocks: LANES agents who lie one after another in a row of cells, as the lanes of vector instructions.

The block's numbers lie in one array with rows of LANES, in which the compiler can tell the rows apart: loops over lanes
have neither branches nor checks. Its last lanes may belong to the next row of cells, or to nobody: what comes of them
is written over, or never read.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.agents.crowd.cells_kernels import COLUMNS_ROUND, NEIGHBOUR_RANGE, ROWS_ROUND, X, Z
from live.base.jit import part

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

LANES = 8

# rows of what is asked for an agent
PER_SEPARATION2, LATEST, ALIGNMENT, COHESION, ASK_ROWS = 0, 1, 2, 3, 4

# rows of the sums of an agent
PUSH_X, PUSH_Z = 0, 1
"""Ways from the neighbours [m], weighted with (1 - d² / separation²)²."""
WEIGHT, FLOCK_X, FLOCK_Z = 2, 3, 4
"""Sum of weights (1 - d² / range²)²; with these, alignment x relative velocity + cohesion x way to the neighbour."""
AVOID_X, AVOID_Z = 5, 6
"""Acceleration that avoids predicted collisions [m/s²]."""
SUM_ROWS = 7

# rows of a block: X to RADIUS, the number of the lane, what is asked, the sums
LANE, ASKED, SUMS, BLOCK_ROWS = 5, 6, 10, 17

_ZERO: Any = np.float32(0.0)
_RANGE2: Any = np.float32(NEIGHBOUR_RANGE**2 * 1.0001)
_1, _2, _3, _4, _5, _6, _7 = (np.uint64(j) for j in range(1, LANES))  # unsigned: they cannot count from the end


@part
def all_sleep(awake: Int32, columns: int, rows: int, row: int, first: int, last: int) -> bool:
    """Whether nobody is awake within reach of columns first to last of `row`."""
    left, right = max(first - COLUMNS_ROUND, 0), min(last + COLUMNS_ROUND + 1, columns)
    count = 0
    for r in range(max(row - ROWS_ROUND, 0), min(row + ROWS_ROUND + 1, rows)):
        count += awake[r * columns + right] - awake[r * columns + left]
    return count == 0


@part
def leave_asleep(
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
    """All sums of those of slots first:last are 0 in whose own reach nobody is awake."""
    for c in range(first_column, last_column + 1):
        if all_sleep(awake, columns, rows, row, c, c):
            for i in range(max(start[row * columns + c], first), min(start[row * columns + c + 1], last)):
                for f in range(SUM_ROWS):
                    sums[f, i] = _ZERO


@part
def find_near(
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
    """Write into `near` who is within range of the box round slots first:last, in these columns; returns how many."""
    x0, x1, z0, z1 = sorted_[X, first], sorted_[X, first], sorted_[Z, first], sorted_[Z, first]
    for s in range(first + 1, last):
        x0, x1 = min(x0, sorted_[X, s]), max(x1, sorted_[X, s])
        z0, z1 = min(z0, sorted_[Z, s]), max(z1, sorted_[Z, s])
    left, right = max(first_column - COLUMNS_ROUND, 0), min(last_column + COLUMNS_ROUND + 1, columns)
    count = 0
    for r in range(max(row - ROWS_ROUND, 0), min(row + ROWS_ROUND + 1, rows)):
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


@part
def copy_lanes(source: Float32, f: int, first: int, to: Float32, g: int, begin: int) -> None:
    """Copy LANES numbers of row f from `first` on into row g from `begin` on: all are read first, so with one load."""
    s: Any = np.uint64(first)
    t: Any = np.uint64(begin)
    a0, a1, a2, a3 = source[f, s], source[f, s + _1], source[f, s + _2], source[f, s + _3]
    a4, a5, a6, a7 = source[f, s + _4], source[f, s + _5], source[f, s + _6], source[f, s + _7]
    to[g, t], to[g, t + _1], to[g, t + _2], to[g, t + _3] = a0, a1, a2, a3
    to[g, t + _4], to[g, t + _5], to[g, t + _6], to[g, t + _7] = a4, a5, a6, a7


@part
def fill_block(sorted_: Float32, asks: Float32, first: int, block: Float32) -> None:
    """What the loops have to know of the agents from slot `first` on, and sums of 0."""
    for f in range(5):
        copy_lanes(sorted_, f, first, block, f, 0)
    for f in range(ASK_ROWS):
        copy_lanes(asks, f, first, block, ASKED + f, 0)
    for f in range(SUM_ROWS):
        for j in range(LANES):
            block[SUMS + f, j] = _ZERO
