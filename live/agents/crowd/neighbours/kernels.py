"""The neighbour pass: separation, alignment, cohesion and predicted collisions, in rows of lanes.

The agents of the 3 x 3 cells round a cell are copied once into lanes (structure of arrays, in the nearest cache), then
one loop without branches runs over them for each agent of the cell; the compiler turns it into vector instructions.
The sums are kept in LANES separate lanes and added in a fixed order, so that they are the same on every machine.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.agents.crowd.cells.kernels import NEIGHBOUR_RANGE, RADIUS, SORTED_ROWS, VX, VZ, X, YIELD, Z
from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

LANES = 16
CANDIDATES = 256
"""Neighbours looked at together; more of them come in several turns."""

# rows of the sums of an agent
PUSH_X, PUSH_Z = 0, 1
"""Separation, 1 at most for one neighbour."""
WEIGHT, FLOCK_VX, FLOCK_VZ, FLOCK_X, FLOCK_Z = 2, 3, 4, 5, 6
"""Sums of weights, of weighted velocities relative to hers, of weighted ways to the neighbours."""
AVOID_X, AVOID_Z = 7, 8
"""Acceleration that avoids predicted collisions [m/s²]."""
NEAREST = 9
"""Least square of distance less that of contact distance and margin [m²]; below 0: somebody may touch her."""
SUM_ROWS = 10

CONTACT_MARGIN = 0.3
"""Metres of gap from which on two bodies are watched for contact."""

_F = np.float32
_ZERO: Any = _F(0.0)
_HALF: Any = _F(0.5)
_ONE: Any = _F(1.0)
_TINY: Any = _F(1e-12)
_MARGIN: Any = _F(CONTACT_MARGIN)
_FAR: Any = _F(1e9)
_RANGE2: Any = _F(NEIGHBOUR_RANGE * NEIGHBOUR_RANGE)
_PER_RANGE2: Any = _F(1.0 / NEIGHBOUR_RANGE**2)
_SEPARATION_PEAK: Any = _F(25.0 * math.sqrt(5.0) / 16.0)  # of s (1 - s²)², at s = 1/√5


@kernel("i8(f4[:,::1], i4[::1], i8, i8, i8, f4[:,::1], i4[::1], i8, i8)")
def _gather(
    sorted_: Float32,
    start: Int32,
    columns: int,
    rows: int,
    cell: int,
    lanes: Float32,
    slots: Int32,
    skip: int,
    room: int,
) -> int:
    """Copy candidates skip:skip + room of the cells round `cell` into lanes; returns how many, padded by far ones."""
    row, column = cell // columns, cell % columns
    n, passed = 0, 0
    for r in range(max(row - 1, 0), min(row + 2, rows)):
        first = start[r * columns + max(column - 1, 0)]
        last = start[r * columns + min(column + 1, columns - 1) + 1]
        begin = first + max(skip - passed, 0)
        passed += last - first
        end = min(last, begin + room - n)
        for s in range(begin, end):
            slots[n] = s
            for f in range(SORTED_ROWS):
                lanes[f, n] = sorted_[f, s]
            n += 1
    padded = (n + LANES - 1) // LANES * LANES
    for k in range(n, padded):
        slots[k] = -1
        lanes[X, k], lanes[Z, k], lanes[VX, k], lanes[VZ, k] = _FAR, _FAR, _ZERO, _ZERO
        lanes[RADIUS, k], lanes[YIELD, k] = _ZERO, _ZERO
    return n


@kernel("i8(f4[:,::1], i4[::1], f8[::1], f4[:,::1], f4[:,::1], f4[::1], i4[::1])")
def sum_neighbours(
    sorted_: Float32,
    start: Int32,
    grid: Float64,
    asks: Float32,
    sums: Float32,
    params: Float32,
    pairs: Int32,
) -> int:
    """All sums (SUM_ROWS, n) of all sorted agents; returns the number of pairs near contact, written into `pairs`.

    asks (2, n): the square of 1 / separation distance [1/m²] and the horizon [s] of each sorted agent.
    """
    lanes = np.empty((SORTED_ROWS, CANDIDATES), np.float32)
    slots = np.empty(CANDIDATES, np.int32)
    acc = np.empty((SUM_ROWS, LANES), np.float32)
    columns, rows = int(grid[2]), int(grid[3])
    strength, side, tau = params[7], params[8], params[6]
    pair_count = 0
    for cell in range(columns * rows):
        if start[cell] == start[cell + 1]:
            continue
        skip = 0
        while True:
            n = _gather(sorted_, start, columns, rows, cell, lanes, slots, skip, CANDIDATES)
            blocks = (n + LANES - 1) // LANES
            for i in range(start[cell], start[cell + 1]):
                xi, zi, vxi, vzi = sorted_[X, i], sorted_[Z, i], sorted_[VX, i], sorted_[VZ, i]
                ri, yi = sorted_[RADIUS, i], sorted_[YIELD, i]
                per_sep2, horizon = asks[0, i], asks[1, i]
                per_horizon = _ONE / horizon
                for f in range(SUM_ROWS):
                    for l in range(LANES):
                        acc[f, l] = _ZERO
                for b in range(blocks):
                    for l in range(LANES):
                        k = b * LANES + l
                        dx, dz = xi - lanes[X, k], zi - lanes[Z, k]
                        ux, uz = vxi - lanes[VX, k], vzi - lanes[VZ, k]
                        other = slots[k] != i
                        d2 = dx * dx + dz * dz
                        same = d2 < _TINY
                        dx = (_F(1e-6) if slots[k] > i else _F(-1e-6)) if same else dx
                        reach = ri + lanes[RADIUS, k]
                        share = yi * (_F(2.0) - lanes[YIELD, k])
                        inside = other and d2 < _RANGE2
                        # separation
                        q = max(_ONE - d2 * per_sep2, _ZERO)
                        w = q * q if other else _ZERO
                        acc[PUSH_X, l] += w * dx
                        acc[PUSH_Z, l] += w * dz
                        # flock
                        q = max(_ONE - d2 * _PER_RANGE2, _ZERO)
                        w = q * q if other else _ZERO
                        acc[WEIGHT, l] += w
                        acc[FLOCK_VX, l] -= w * ux
                        acc[FLOCK_VZ, l] -= w * uz
                        acc[FLOCK_X, l] -= w * dx
                        acc[FLOCK_Z, l] -= w * dz
                        # predicted collision
                        tx, tz = dx - side * dz, dz + side * dx
                        closing = -(tx * ux + tz * uz)
                        u2 = ux * ux + uz * uz
                        c = max(d2 - reach * reach, _F(1e-4))
                        disc = closing * closing - u2 * c
                        root = math.sqrt(max(disc, _F(1e-6)))
                        t = c / max(closing + root, _F(1e-6))
                        coming = inside and closing > _ZERO and disc > _ZERO and t < horizon
                        t = min(t, horizon)
                        fade = _ONE - t * per_horizon
                        t1 = max(t, _F(0.1))
                        force = (
                            strength * fade * fade * (_F(2.0) * tau + t1) / (tau * t1 * t1 * t1 * max(root, _F(0.05)))
                        )
                        nx, nz = tx + ux * t, tz + uz * t
                        force = min(force, _F(20.0) / max(reach, _F(0.05)))
                        force = force * share if coming else _ZERO
                        acc[AVOID_X, l] += force * nx
                        acc[AVOID_Z, l] += force * nz
                        touch = reach + _MARGIN
                        acc[NEAREST, l] = min(acc[NEAREST, l], (d2 - touch * touch) if other else _ZERO)
                for f in range(SUM_ROWS - 1):
                    total = _ZERO
                    for l in range(LANES):
                        total += acc[f, l]
                    sums[f, i] = total if skip == 0 else sums[f, i] + total
                nearest = _ZERO
                for l in range(LANES):
                    nearest = min(nearest, acc[NEAREST, l])
                if nearest < _ZERO:
                    for k in range(n):
                        if slots[k] > i and 2 * pair_count + 2 <= pairs.shape[0]:
                            dx, dz = xi - lanes[X, k], zi - lanes[Z, k]
                            touch = ri + lanes[RADIUS, k] + _MARGIN
                            if dx * dx + dz * dz < touch * touch:
                                pairs[2 * pair_count], pairs[2 * pair_count + 1] = i, slots[k]
                                pair_count += 1
            if n < CANDIDATES:
                break
            skip += CANDIDATES
    return pair_count
