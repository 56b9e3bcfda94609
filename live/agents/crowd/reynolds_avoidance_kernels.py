"""Collision avoidance of the thesis: Reynolds' unaligned collision avoidance with two distances (T082, T108)."""

import math

import numpy as np
import numpy.typing as npt

from live.agents.crowd.spatial_grid_kernels import (
    AVOID_X,
    AVOID_Z,
    COLUMN_REACH,
    MOBILITY,
    NEIGHBOUR_RANGE,
    RADIUS,
    ROW_REACH,
    VX,
    VZ,
    X,
    Z,
)
from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

MAX_TIME_TO_COLLISION = 2.0
"""Latest time to collision [s] that is avoided."""
CLEARANCE = 0.2
"""Gap [m] that the nearest approach must leave."""
SLOW_SHARE = 0.4
"""Share of the top speed kept below distance d_s; the thesis gives no number."""


@kernel("UniTuple(f8,2)(f8,f8,f8,f8,f8)")
def dodge(dx: float, dz: float, ux: float, uz: float, reach: float) -> tuple[float, float]:
    """Return the avoidance vector away from the nearest approach to one neighbour, length at most 1, larger when
    sooner.

    dx, dz: from the neighbour to the agent [m]; ux, uz: velocity relative to it [m/s]; reach: distance to keep [m]. The
    two agents of a pair get mirrored results; head on, both go to their right.
    """
    closing, u2 = -(dx * ux + dz * uz), ux * ux + uz * uz
    if closing <= 0.0 or u2 < 1e-6 or closing > MAX_TIME_TO_COLLISION * u2:
        return 0.0, 0.0
    when = closing / u2
    nx, nz = dx + ux * when, dz + uz * when
    gap = math.sqrt(nx * nx + nz * nz)
    if gap > reach:
        return 0.0, 0.0
    if gap < 0.1 * reach:
        nx, nz = -uz, ux
        gap = math.sqrt(u2)
    urgency = 1.0 - when / MAX_TIME_TO_COLLISION
    return urgency * nx / gap, urgency * nz / gap


@kernel("UniTuple(f8,3)(f4[:,::1], i4[::1], i8, i8, i8, i8, f8)")
def sum_dodges(
    sorted_: Float32, start: Int32, columns: int, rows: int, cell: int, i: int, d_f: float
) -> tuple[float, float, float]:
    """Return the distance [m] of the nearest approaching neighbour (1e9: none within d_f) and the sum of all dodges."""
    nearest, sum_x, sum_z = 1e9, 0.0, 0.0
    for r in range(max(cell // columns - ROW_REACH, 0), min(cell // columns + ROW_REACH + 1, rows)):
        first = start[r * columns + max(cell % columns - COLUMN_REACH, 0)]
        last = start[r * columns + min(cell % columns + COLUMN_REACH, columns - 1) + 1]
        for s in range(first, last):
            dx, dz = float(sorted_[X, i] - sorted_[X, s]), float(sorted_[Z, i] - sorted_[Z, s])
            d = math.sqrt(dx * dx + dz * dz)
            if s == i or d > min(d_f, NEIGHBOUR_RANGE) or d < 1e-6:
                continue
            ux, uz = float(sorted_[VX, i] - sorted_[VX, s]), float(sorted_[VZ, i] - sorted_[VZ, s])
            if dx * ux + dz * uz < -1e-3 * d:
                nearest = min(nearest, d)
            x, z = dodge(dx, dz, ux, uz, sorted_[RADIUS, i] + sorted_[RADIUS, s] + CLEARANCE)
            sum_x += x * sorted_[MOBILITY, s]
            sum_z += z * sorted_[MOBILITY, s]
    return nearest, sum_x, sum_z


@kernel("void(f4[:,::1], i4[::1], f8[::1], f4[::1], f4[:,::1], i4[::1], f4[::1])")
def avoid_by_distance(
    sorted_: Float32,
    start: Int32,
    grid: Float64,
    commands: Float32,
    sums: Float32,
    slot_agent: Int32,
    params: Float32,
) -> None:
    """Write avoidance into `sums`; reduce the other behaviours and the speed limit in `commands` (8 A,).

    T108: closer than d_s to an approaching neighbour, an agent ignores all other behaviours, keeps its velocity except
    for the avoidance, and slows down. Up to d_f everything is combined; there is no avoidance beyond d_f.
    """
    columns, rows = int(grid[2]), int(grid[3])
    most, d_s, d_f = float(params[3]), float(params[9]), float(params[10])
    for cell in range(columns * rows):
        for i in range(start[cell], start[cell + 1]):
            nearest, x, z = sum_dodges(sorted_, start, columns, rows, cell, i, d_f)
            size = math.sqrt(x * x + z * z)
            scale = most * (2.0 - sorted_[MOBILITY, i]) / max(size, 1.0)
            sums[AVOID_X, i] = x * scale
            sums[AVOID_Z, i] = z * scale
            if nearest < d_s and sorted_[MOBILITY, i] < 2.0:
                k = 8 * slot_agent[i]
                firm = commands[k + 6]
                commands[k] = firm * commands[k] + (np.float32(1.0) - firm) * sorted_[VX, i]
                commands[k + 1] = firm * commands[k + 1] + (np.float32(1.0) - firm) * sorted_[VZ, i]
                commands[k + 2] *= np.float32(SLOW_SHARE) + firm * np.float32(1.0 - SLOW_SHARE)
                sums[2, i], sums[3, i], sums[4, i] = 0.0, 0.0, 0.0
