"""The neighbour pass: separation, alignment, cohesion and predicted collisions, in rows of lanes.

For each row of cells the agents of this row and of those beside it are copied, column after column, into lanes
(structure of arrays), so that all who may matter to an agent are one stretch of lanes, which stays in the nearest
cache. One loop without branches runs over them for each agent; the compiler turns it into vector instructions. Whatever
lies in the last block beyond that stretch is farther away than anybody is seen. The sums are kept in LANES separate
lanes and added in a fixed order, so that they are the same on every machine. An agent meets herself, too: at no
distance and no relative speed she adds nothing but 1 to WEIGHT and to NEAR.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.agents.crowd.cells.kernels import (
    COLUMNS_ROUND,
    GIVE,
    NEIGHBOUR_RANGE,
    RADIUS,
    ROWS_ROUND,
    SORTED_ROWS,
    VX,
    VZ,
    X,
    Z,
)
from live.base.jit import kernel, part

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

LANES = 16

# rows of what is asked for an agent
PER_SEPARATION2, LATEST, ALIGNMENT, COHESION, ASK_ROWS = 0, 1, 2, 3, 4

# rows of the sums of an agent
PUSH_X, PUSH_Z = 0, 1
"""Ways from the neighbours [m], weighted with (1 - d² / separation²)²."""
WEIGHT, FLOCK_X, FLOCK_Z = 2, 3, 4
"""Sum of weights (1 - d² / range²)²; with these, alignment x relative velocity + cohesion x way to the neighbour."""
AVOID_X, AVOID_Z = 5, 6
"""Acceleration that avoids predicted collisions [m/s²]."""
NEAR = 7
"""How many are near contact."""
SUM_ROWS = 8

CONTACT_MARGIN = 0.3
"""Metres of gap from which on two bodies are watched for contact."""

_F = np.float32
_ZERO: Any = _F(0.0)
_ONE: Any = _F(1.0)
_TWO: Any = _F(2.0)
_FOUR: Any = _F(4.0)
_GRAZE: Any = _F(0.05)
_MARGIN: Any = _F(CONTACT_MARGIN)
_FAR: Any = _F(1e3)
_PER_RANGE2: Any = _F(1.0 / NEIGHBOUR_RANGE**2)
_MOST_W: Any = _F(1.0 / 0.15)
_CAP: Any = _F(40.0)
_LEAST_C: Any = _F(1e-3)
_TINY: Any = _F(1e-9)


@part
def _gather_row(
    sorted_: Float32, start: Int32, columns: int, rows: int, row: int, lanes: Float32, slots: Int32, column_end: Int32
) -> int:
    """Copy the agents of the rows round `row` into lanes, column by column, and far ones after them; returns how many.

    column_end[c + 1]: where column c ends.
    """
    n = 0
    for c in range(columns):
        for r in range(max(row - ROWS_ROUND, 0), min(row + ROWS_ROUND + 1, rows)):
            for s in range(start[r * columns + c], start[r * columns + c + 1]):
                to: Any = np.uint64(n)  # unsigned: it cannot count from the end
                at: Any = np.uint64(s)
                for f in range(SORTED_ROWS):
                    lanes[f, to] = sorted_[f, at]
                slots[to] = s
                n += 1
        column_end[c + 1] = n
    for k in range(n, n + LANES):
        lanes[X, k], lanes[Z, k], lanes[VX, k], lanes[VZ, k] = _FAR, _FAR, _ZERO, _ZERO
        lanes[RADIUS, k], lanes[GIVE, k] = _ZERO, _ZERO
    return n


@part
def _all_sleep(awake: Int32, columns: int, rows: int, row: int, left: int, right: int) -> bool:
    """Whether nobody is awake in columns left:right of `row` and the rows round it."""
    count = 0
    for r in range(max(row - ROWS_ROUND, 0), min(row + ROWS_ROUND + 1, rows)):
        count += awake[r * columns + right] - awake[r * columns + left]
    return count == 0


@part
def _note_pairs(
    lanes: Float32,
    slots: Int32,
    hits: Int32,
    first: int,
    last: int,
    i: int,
    x: Any,
    z: Any,
    watched: Any,
    pairs: Int32,
    pair_count: int,
) -> int:
    """Write down with which later ones of lanes first:last agent i is near contact; returns the new number of pairs."""
    for m in range(last - first):
        k: Any = np.uint64(first + m)
        dx, dz = x - lanes[X, k], z - lanes[Z, k]
        touch = watched + lanes[RADIUS, k]
        hits[m] = np.int32(dx * dx + dz * dz < touch * touch) & np.int32(slots[k] > i)
    for m in range(last - first):
        if hits[m] != 0 and 2 * pair_count + 2 <= pairs.shape[0]:
            pairs[2 * pair_count], pairs[2 * pair_count + 1] = i, slots[first + m]
            pair_count += 1
    return pair_count


@part
def _sum_lanes(
    lanes: Float32,
    acc: Float32,
    sums: Float32,
    asks: Float32,
    i: int,
    own: tuple[Any, Any, Any, Any, Any],
    first: int,
    last: int,
    side: Any,
    per_tau: Any,
) -> None:
    """Sums of agent i, of whom `own` is x, z, vx, vz and the radius with the margin, over lanes first:last."""
    xi, zi, vxi, vzi, watched = own
    per_sep2, latest = asks[PER_SEPARATION2, i], asks[LATEST, i]
    align, cohere = asks[ALIGNMENT, i], asks[COHESION, i]
    for f in range(SUM_ROWS):
        for j in range(LANES):
            acc[f, j] = _ZERO
    for b in range((last - first + LANES - 1) // LANES):
        for j in range(LANES):
            k: Any = np.uint64(first + b * LANES + j)  # unsigned: contiguous loads
            dx, dz = xi - lanes[X, k], zi - lanes[Z, k]
            ux, uz = vxi - lanes[VX, k], vzi - lanes[VZ, k]
            d2 = dx * dx + dz * dz
            # separation
            q = max(_ONE - d2 * per_sep2, _ZERO)
            w = q * q
            acc[PUSH_X, j] += w * dx
            acc[PUSH_Z, j] += w * dz
            # flock
            seen = max(_ONE - d2 * _PER_RANGE2, _ZERO)
            w = seen * seen
            acc[WEIGHT, j] += w
            acc[FLOCK_X, j] -= w * (align * ux + cohere * dx)
            acc[FLOCK_Z, j] -= w * (align * uz + cohere * dz)
            # predicted collision; w is 1 / time to it
            tx, tz = dx + side * dz, dz - side * dx
            closing = max(-(tx * ux + tz * uz), _ZERO)
            u2 = ux * ux + uz * uz
            touch = watched + lanes[RADIUS, k]
            reach = touch - _MARGIN
            reach2 = reach * reach
            c = max(d2 - reach2, _LEAST_C)
            disc = max(closing * closing - u2 * c, _ZERO)
            root = math.sqrt(disc)
            blunt = disc + _GRAZE * (u2 * reach2) + _TINY
            inverse = _ONE / (c * blunt)
            w = min((closing + root) * (blunt * inverse), _MOST_W)
            gate = (lanes[GIVE, k] * min(_FOUR * seen, _ONE)) * ((c * inverse) * root)
            h = max(w - latest, _ZERO)
            force = min((_TWO * h + per_tau) * h * gate, _CAP)
            acc[AVOID_X, j] += force * (tx * w + ux)
            acc[AVOID_Z, j] += force * (tz * w + uz)
            acc[NEAR, j] += _ONE if d2 < touch * touch else _ZERO
    for f in range(SUM_ROWS):
        sums[f, i] = (
            ((acc[f, 0] + acc[f, 8]) + (acc[f, 4] + acc[f, 12])) + ((acc[f, 2] + acc[f, 10]) + (acc[f, 6] + acc[f, 14]))
        ) + (
            ((acc[f, 1] + acc[f, 9]) + (acc[f, 5] + acc[f, 13])) + ((acc[f, 3] + acc[f, 11]) + (acc[f, 7] + acc[f, 15]))
        )


@kernel(
    "i8(f4[:,::1], i4[::1], f8[::1], f4[:,::1], f4[:,::1], f4[::1], f4[:,::1], "
    "i4[::1], i4[::1], i4[::1], i4[::1], i4[::1])"
)
def sum_neighbours(
    sorted_: Float32,
    start: Int32,
    grid: Float64,
    asks: Float32,
    sums: Float32,
    params: Float32,
    lanes: Float32,
    slots: Int32,
    column_end: Int32,
    awake: Int32,
    hits: Int32,
    pairs: Int32,
) -> int:
    """All sums (SUM_ROWS, n) of all sorted agents; returns the number of pairs near contact, written into `pairs`.

    asks (ASK_ROWS, n): the square of 1 / separation distance [1/m²], 1 / horizon [1/s], weights of alignment and
    cohesion of each sorted agent. awake (cells + 1,): how many agents are awake in the cells before; where all round a
    cell sleep, all sums are 0. Scratch: lanes (SORTED_ROWS, n + LANES), slots, hits (n + LANES,), column_end
    (columns + 1,).
    """
    acc = np.empty((SUM_ROWS, LANES), np.float32)
    columns, rows = int(grid[2]), int(grid[3])
    strength, side, per_tau = params[7], params[8], _ONE / params[6]
    pair_count = 0
    column_end[0] = 0
    for cell in range(columns * rows):
        row, column = cell // columns, cell % columns
        if column == 0:
            _gather_row(sorted_, start, columns, rows, row, lanes, slots, column_end)
        left, right = max(column - COLUMNS_ROUND, 0), min(column + COLUMNS_ROUND + 1, columns)
        first, last = column_end[left], column_end[right]
        if start[cell] == start[cell + 1]:
            continue
        if _all_sleep(awake, columns, rows, row, left, right):
            for f in range(SUM_ROWS):
                sums[f, start[cell] : start[cell + 1]] = _ZERO
            continue
        for i in range(start[cell], start[cell + 1]):
            xi, zi, vxi, vzi = sorted_[X, i], sorted_[Z, i], sorted_[VX, i], sorted_[VZ, i]
            ri, yi = sorted_[RADIUS, i], (_TWO - sorted_[GIVE, i]) * strength
            watched = ri + _MARGIN
            _sum_lanes(lanes, acc, sums, asks, i, (xi, zi, vxi, vzi, watched), first, last, side, per_tau)
            sums[AVOID_X, i] *= yi
            sums[AVOID_Z, i] *= yi
            if sums[NEAR, i] > _ONE:
                pair_count = _note_pairs(lanes, slots, hits, first, last, i, xi, zi, watched, pairs, pair_count)
    return pair_count
