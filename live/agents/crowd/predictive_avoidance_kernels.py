"""Neighbour pass: separation, alignment, cohesion and predicted collisions, for blocks of LANES agents at a time.

The agents of a block are consecutive in a row of cells and occupy the vector lanes; all candidates near any of them are
visited one by one. No data moves across lanes, the sums of a block stay in registers, and each agent's sums are added
in slot order regardless of its block: an agent out of range adds exactly zero. A first, branch-free loop sums the cheap
terms and records candidates for a collision or contact; a second loop handles only those. An agent visits itself too:
with zero distance and relative speed it adds only 1 to WEIGHT.

"contract" lets the compiler fuse a product and a sum. Results are reproducible on one machine at any frame timing, and
differ in the last bit on a machine without such an instruction.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.agents.crowd.contact_kernels import CONTACT_MARGIN, append_contact_pairs
from live.agents.crowd.spatial_grid_kernels import (
    ALIGNMENT,
    AVOID_X,
    AVOID_Z,
    BLOCK_ROWS,
    COHESION,
    FLOCK_X,
    FLOCK_Z,
    LANE,
    LANES,
    MOBILITY,
    NEIGHBOUR_RANGE,
    PER_HORIZON,
    PER_SEPARATION2,
    PERSONAL,
    PUSH_X,
    PUSH_Z,
    RADIUS,
    REQUESTS,
    SUM_ROWS,
    SUMS,
    VX,
    VZ,
    WEIGHT,
    X,
    Z,
    all_sleep,
    copy_lanes,
    fill_block,
    find_candidates,
    zero_sleeping_sums,
)
from live.base.jit import inline_kernel, kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

_F = np.float32
_ZERO: Any = _F(0.0)
_ONE: Any = _F(1.0)
_TWO: Any = _F(2.0)
_FOUR: Any = _F(4.0)
_GRAZING: Any = _F(0.05)
_MARGIN: Any = _F(CONTACT_MARGIN)
_CAP: Any = _F(40.0)
_PER_RANGE2: Any = _F(1.0 / NEIGHBOUR_RANGE**2)
_MOST_W: Any = _F(1.0 / 0.15)
_LEAST_C: Any = _F(1e-3)
_TINY: Any = _F(1e-9)
_ROUNDING_MARGIN: Any = _F(
    1.002
)  # exceeds the rounding error, so that the first loop misses no candidate of the second


@inline_kernel
def _sum_all_but_avoidance(
    sorted_: Float32, block: Float32, first: int, near: Int32, count: int, side: Any, meets: Int32, touches: Int32
) -> tuple[int, int]:
    """Sum everything except AVOID_X/AVOID_Z of the block from slot `first` on over all `near`.

    Return the number of entries written into `meets` and `touches`.
    """
    meet_count, touch_count = 0, 0
    for m in range(count):
        k: Any = np.uint64(near[np.uint64(m)])
        xk, zk, vxk, vzk, rk = sorted_[X, k], sorted_[Z, k], sorted_[VX, k], sorted_[VZ, k], sorted_[RADIUS, k]
        later = _F(np.int32(k) - first)
        meet: Any = np.int32(0)
        touch: Any = np.int32(0)
        for j in range(LANES):
            dx, dz = xk - block[X, j], zk - block[Z, j]
            ux, uz = vxk - block[VX, j], vzk - block[VZ, j]
            d2 = dx * dx + dz * dz
            q = max(_ONE - d2 * block[REQUESTS + PER_SEPARATION2, j], _ZERO)
            w = q * q
            block[SUMS + PUSH_X, j] -= w * dx
            block[SUMS + PUSH_Z, j] -= w * dz
            seen = max(_ONE - d2 * _PER_RANGE2, _ZERO)
            w = seen * seen
            block[SUMS + WEIGHT, j] += w
            block[SUMS + FLOCK_X, j] += w * (block[REQUESTS + ALIGNMENT, j] * ux + block[REQUESTS + COHESION, j] * dx)
            block[SUMS + FLOCK_Z, j] += w * (block[REQUESTS + ALIGNMENT, j] * uz + block[REQUESTS + COHESION, j] * dz)
            tx, tz = dx + side * dz, dz - side * dx
            closing = -_ROUNDING_MARGIN * (tx * ux + tz * uz)
            reach = block[RADIUS, j] + rk
            kept = reach + block[REQUESTS + PERSONAL, j]
            c = max(d2 - kept * kept, _LEAST_C)
            disc = closing * closing - (ux * ux + uz * uz) * c
            soon = _TWO * closing - block[REQUESTS + PER_HORIZON, j] * c
            meet = np.int32(meet | np.int32(min(min(disc, soon), seen) > _ZERO))
            reach = reach + _MARGIN
            touch = np.int32(touch | np.int32(min(reach * reach - d2, later - block[LANE, j]) > _ZERO))
        meets[meet_count] = k
        meet_count += meet
        touches[touch_count] = k
        touch_count += touch
    return meet_count, touch_count


@inline_kernel
def _sum_avoidance(sorted_: Float32, block: Float32, meets: Int32, count: int, side: Any, per_tau: Any) -> None:
    """Sum AVOID_X/AVOID_Z of the block over all `meets`."""
    for m in range(count):
        k: Any = np.uint64(meets[np.uint64(m)])
        xk, zk, vxk, vzk, rk = sorted_[X, k], sorted_[Z, k], sorted_[VX, k], sorted_[VZ, k], sorted_[RADIUS, k]
        gk = sorted_[MOBILITY, k]
        for j in range(LANES):
            dx, dz = block[X, j] - xk, block[Z, j] - zk
            ux, uz = block[VX, j] - vxk, block[VZ, j] - vzk
            d2 = dx * dx + dz * dz
            seen = max(_ONE - d2 * _PER_RANGE2, _ZERO)
            tx, tz = dx + side * dz, dz - side * dx
            closing = max(-(tx * ux + tz * uz), _ZERO)
            u2 = ux * ux + uz * uz
            reach = block[RADIUS, j] + rk + block[REQUESTS + PERSONAL, j]
            reach2 = reach * reach
            c = max(d2 - reach2, _LEAST_C)
            disc = max(closing * closing - u2 * c, _ZERO)
            root = math.sqrt(disc)
            blunt = disc + _GRAZING * (u2 * reach2) + _TINY
            inverse = _ONE / (c * blunt)
            w = min((closing + root) * (blunt * inverse), _MOST_W)  # 1 / time to the collision
            gate = (gk * min(_FOUR * seen, _ONE)) * ((c * inverse) * root)
            h = max(w - block[REQUESTS + PER_HORIZON, j], _ZERO)
            force = min((_TWO * h + per_tau) * h * gate, _CAP)
            block[SUMS + AVOID_X, j] += force * (tx * w + ux)
            block[SUMS + AVOID_Z, j] += force * (tz * w + uz)


@kernel(
    "i8(f4[:,::1], i4[::1], f8[::1], f4[:,::1], f4[:,::1], f4[::1], i4[::1], i4[::1], i4[::1], i4[::1], i4[::1])",
    fastmath={"contract"},
)
def sum_neighbours(
    sorted_: Float32,
    start: Int32,
    grid: Float64,
    requests: Float32,
    sums: Float32,
    params: Float32,
    awake: Int32,
    near: Int32,
    meets: Int32,
    touches: Int32,
    pairs: Int32,
) -> int:
    """Compute all sums (SUM_ROWS, n) of all sorted agents; return the number of contact pairs written into `pairs`.

    asks (REQUEST_ROWS, n): the square of 1 / separation distance [1/m²], 1 / horizon [1/s], weights of alignment and
    cohesion, and the gap [m] that avoidance keeps, of each sorted agent. awake (cells + 1,): number of awake agents in
    the preceding cells; if all agents around a cell sleep, its sums are 0. Scratch: near, meets, touches (n + 1,). All
    rows of agents have LANES spare entries.
    """
    block = np.empty((BLOCK_ROWS, LANES), np.float32)
    for j in range(LANES):
        block[LANE, j] = j
    columns, rows = int(grid[2]), int(grid[3])
    strength, side, per_tau = params[7], params[8], _ONE / params[6]
    sleepers = awake[columns * rows] < start[columns * rows]
    pair_count = 0
    for row in range(rows):
        base, column = row * columns, 0
        for first in range(start[base], start[base + columns], LANES):
            last = min(first + LANES, start[base + columns])
            while start[base + column + 1] <= first:
                column += 1
            first_column = column
            while start[base + column + 1] < last:
                column += 1
            if all_sleep(awake, columns, rows, row, first_column, column):
                for f in range(SUM_ROWS):
                    sums[f, first:last] = _ZERO
                continue
            count = find_candidates(sorted_, start, columns, rows, row, first_column, column, first, last, near, meets)
            fill_block(sorted_, requests, first, block)
            meet_count, touch_count = _sum_all_but_avoidance(sorted_, block, first, near, count, side, meets, touches)
            _sum_avoidance(sorted_, block, meets, meet_count, side, per_tau)
            for f in range(SUM_ROWS):
                copy_lanes(block, SUMS + f, 0, sums, f, first)
            if sleepers:
                zero_sleeping_sums(sums, start, awake, columns, rows, row, first_column, column, first, last)
            for i in range(first, last):
                mine = (_TWO - sorted_[MOBILITY, i]) * strength
                sums[AVOID_X, i] *= mine
                sums[AVOID_Z, i] *= mine
                if touch_count > 0 and sums[WEIGHT, i] > _ZERO:
                    pair_count = append_contact_pairs(sorted_, i, touches, touch_count, pairs, pair_count)
    return pair_count
