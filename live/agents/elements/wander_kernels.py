"""Path following and undirected motion: wandering, flocking and the residual wander while spreading (T082, T109)."""

import math

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import PRESENCE, SPEED
from live.agents.elements.element_table_kernels import (
    ADDRESSED_LEVEL,
    CLOSED,
    CORNERS,
    HALF_DEPTH,
    HALF_WIDTH,
    LEVEL,
    RADIUS,
    SEED,
    STRENGTH,
    SWITCHED,
    TIME,
    add_velocity,
    newest,
)
from live.agents.steering_kernels import follow_path, wander
from live.base.element_kinds import FLOCK, PATH, SPREADER, WANDER
from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
UInt64 = npt.NDArray[np.uint64]

PATH_WIDTH = 0.3
"""Default half width of a path [m]."""
SPREADING_WANDER = 0.4
"""Share of the top speed used for wandering while dancers spread (T109), so that they never fully rest."""


@kernel("void(f8[:,::1],u8[::1],f4[:,:,::1],i4[::1],f4[:,::1],f4[:,::1],f4[:,::1],u8[::1],f8[::1],f8[:,::1])")
def follow_paths(
    table: Float64,
    masks: UInt64,
    vertices: Float32,
    active: Int32,
    position: Float32,
    velocity: Float32,
    commands: Float32,
    groups: UInt64,
    numbers: Float64,
    sums: Float64,
) -> None:
    """Add the velocity of dancers that follow the newest path that addresses them."""
    for i in range(position.shape[0]):
        if sums[i, ADDRESSED_LEVEL] <= 0.0:
            continue
        row = newest(table, masks, active, PATH, groups[i])
        if row < 0:
            continue
        width = table[row, RADIUS] if table[row, RADIUS] > 0.0 else PATH_WIDTH
        x, z, vx, vz = position[i, 0], position[i, 1], velocity[i, 0], velocity[i, 1]
        corners, closed = int(table[row, CORNERS]), table[row, CLOSED] > 0.0
        fx, fz = follow_path(vertices, row, corners, closed, width, x, z, vx, vz, commands[i, SPEED])
        size = table[row, LEVEL] * table[row, STRENGTH]
        add_velocity(sums, i, size * fx, size * fz, table[row, LEVEL], numbers[SWITCHED] > 0.0)


@kernel("i8(f8[:,::1],u8[::1],i4[::1],i8,f4[:,::1],u8[::1],i4[::1])")
def find_members(
    table: Float64, masks: UInt64, active: Int32, row: int, commands: Float32, groups: UInt64, member: Int32
) -> int:
    """Write the present agents whose newest spreader is the element `row` to `member` (A,); return their number."""
    members = 0
    for i in range(groups.shape[0]):
        if commands[i, PRESENCE] > 0.0 and newest(table, masks, active, SPREADER, groups[i]) == row:
            member[members] = i
            members += 1
    return members


@kernel("void(f8[:,::1],i8,f4[:,::1],i4[::1],f8[:,::1],f8[::1],f8[:,::1],i8,i8)")
def add_spreading(
    table: Float64, row: int, commands: Float32, order: Int32, wish: Float64, numbers: Float64, sums: Float64,
    begin: int, end: int,
) -> None:  # fmt: skip
    """Add the velocity `wish` (A, 2) [m/s] of the agents `order` begin..end-1, who spread by the element `row`."""
    for n in range(begin, end):
        i = order[n]
        fx, fz = wish[i, 0], wish[i, 1]
        # from m/s to a fraction of the top speed, at most 1
        size = table[row, LEVEL] * max(table[row, STRENGTH], 0.0)
        size /= max(math.sqrt(fx * fx + fz * fz), commands[i, SPEED], 1e-6)
        add_velocity(sums, i, size * fx, size * fz, table[row, LEVEL], numbers[SWITCHED] > 0.0)


@kernel("void(f8[:,::1],u8[::1],i4[::1],f4[:,::1],f4[:,::1],u8[::1],f8[::1],f8[:,::1],i8,i8)")
def wander_agents(
    table: Float64,
    masks: UInt64,
    active: Int32,
    position: Float32,
    velocity: Float32,
    groups: UInt64,
    numbers: Float64,
    sums: Float64,
    begin: int,
    end: int,
) -> None:
    """Add the wander velocity of those of the agents begin..end-1 who wander, flock or, reduced, spread."""
    seed, half_width, half_depth = int(numbers[SEED]), numbers[HALF_WIDTH], numbers[HALF_DEPTH]
    for i in range(begin, end):
        if sums[i, ADDRESSED_LEVEL] <= 0.0:
            continue
        size, influence = 0.0, 0.0
        row = newest(table, masks, active, WANDER, groups[i])
        if row >= 0:
            size, influence = table[row, LEVEL] * table[row, STRENGTH], table[row, LEVEL]
        row = newest(table, masks, active, FLOCK, groups[i])
        if row >= 0:
            size = max(size, table[row, LEVEL] * table[row, STRENGTH])
            influence = max(influence, table[row, LEVEL])
        row = newest(table, masks, active, SPREADER, groups[i])
        if row >= 0:
            size = max(size, table[row, LEVEL] * table[row, STRENGTH] * SPREADING_WANDER)
        if size > 0.0:
            x, z, vx, vz = position[i, 0], position[i, 1], velocity[i, 0], velocity[i, 1]
            fx, fz = wander(x, z, vx, vz, half_width, half_depth, seed, i, numbers[TIME])
            add_velocity(sums, i, size * fx, size * fz, influence, numbers[SWITCHED] > 0.0)
