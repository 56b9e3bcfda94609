"""Crossing over (T110): where each dancer goes on the other side of the line, fixed when the crossing begins."""

import math

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import PRESENCE
from live.agents.elements.element_kinds import CROSSING
from live.agents.elements.element_table_kernels import (
    HEARD,
    LEVEL,
    ROWS,
    SERIAL,
    STRENGTH,
    SWITCHED,
    addresses,
    newest,
    take,
)
from live.agents.steering_kernels import arrive, hash_unit
from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
UInt64 = npt.NDArray[np.uint64]

# columns of what is remembered of an agent (A, 3)
OWNER, GOAL_X, GOAL_Z = 0, 1, 2
MEMORY_COLUMNS = 3

CLEAR = 0.75
"""Nobody's place on the other side is nearer to the line than this [m]."""
MARGIN = 0.45
"""Nor nearer to the stage edge [m]."""
APART = 0.75
"""Nor two places to each other [m]."""
SLOWING = 1.0
"""Within this distance [m] of her place a dancer slows down."""
PARTING_WORK = 3_000_000
"""Pairs looked at while places part, at most: larger crowds are left to separation."""


@kernel("f8(f8,f8,f8,f8,f8,f8,f8)")
def depth_of_side(
    side: float, ax: float, az: float, nx: float, nz: float, half_width: float, half_depth: float
) -> float:
    """How far the stage goes on a side (+1, -1) of the line through (ax, az) with unit normal (nx, nz) [m]."""
    corner = abs(nx) * half_width + abs(nz) * half_depth
    return corner - side * (ax * nx + az * nz)


@kernel("UniTuple(f8,2)(f8,f8,f8,f8,f8,f8,f8,f8,f8)")
def over_there(
    x: float,
    z: float,
    side: float,
    ax: float,
    az: float,
    nx: float,
    nz: float,
    half_width: float,
    half_depth: float,
) -> tuple[float, float]:
    """The place on the other side of the line that answers (x, z), which lies on `side` of it: on the same normal.

    Where both sides are equally deep it is the mirror image; else distances from the line shrink or grow with them.
    """
    own = max(depth_of_side(side, ax, az, nx, nz, half_width, half_depth), 0.1)
    other = max(depth_of_side(-side, ax, az, nx, nz, half_width, half_depth), 0.1)
    distance = side * ((x - ax) * nx + (z - az) * nz)
    way = distance + max(distance * other / own, CLEAR)
    goal_x, goal_z = x - side * way * nx, z - side * way * nz
    edge_x, edge_z = max(half_width - MARGIN, 0.0), max(half_depth - MARGIN, 0.0)
    return min(max(goal_x, -edge_x), edge_x), min(max(goal_z, -edge_z), edge_z)


@kernel("void(f8[:,::1],f8,f8,f8,f8,f8,f8,f8,i8)")
def part_goals(
    memory: Float64,
    owner: float,
    ax: float,
    az: float,
    nx: float,
    nz: float,
    half_width: float,
    half_depth: float,
    seed: int,
) -> None:
    """Move the goals of a crossing apart that are too near to each other, each on its side and on the stage."""
    agents = memory.shape[0]
    rounds = min(40, PARTING_WORK // max(agents * agents, 1))
    edge_x, edge_z = max(half_width - MARGIN, 0.0), max(half_depth - MARGIN, 0.0)
    for _ in range(rounds):
        moved = False
        for i in range(agents):
            if memory[i, OWNER] != owner:
                continue
            for j in range(i + 1, agents):
                if memory[j, OWNER] != owner:
                    continue
                dx, dz = memory[j, GOAL_X] - memory[i, GOAL_X], memory[j, GOAL_Z] - memory[i, GOAL_Z]
                d2 = dx * dx + dz * dz
                if d2 >= (APART - 0.01) ** 2:
                    continue
                d = math.sqrt(d2)
                if d < 1e-6:
                    angle = 2.0 * math.pi * hash_unit(seed, i, j)
                    dx, dz, d = 1e-6 * math.sin(angle), 1e-6 * math.cos(angle), 1e-6
                half = 0.5 * (APART - d) / d
                memory[i, GOAL_X] -= half * dx
                memory[i, GOAL_Z] -= half * dz
                memory[j, GOAL_X] += half * dx
                memory[j, GOAL_Z] += half * dz
                moved = True
        if not moved:
            break
        for i in range(agents):
            if memory[i, OWNER] == owner:
                gx = min(max(memory[i, GOAL_X], -edge_x), edge_x)
                gz = min(max(memory[i, GOAL_Z], -edge_z), edge_z)
                away = (gx - ax) * nx + (gz - az) * nz
                if abs(away) < CLEAR:
                    push = math.copysign(CLEAR, away) - away
                    gx, gz = gx + push * nx, gz + push * nz
                memory[i, GOAL_X] = min(max(gx, -edge_x), edge_x)
                memory[i, GOAL_Z] = min(max(gz, -edge_z), edge_z)


@kernel(
    "i8(f8[:,::1],u8[::1],f4[:,:,::1],i4[::1],f4[:,::1],f4[:,::1],u8[::1],f8[:,::1],f8,f8,i8)",
)
def claim(
    table: Float64,
    masks: UInt64,
    vertices: Float32,
    active: Int32,
    position: Float32,
    wants: Float32,
    groups: UInt64,
    memory: Float64,
    half_width: float,
    half_depth: float,
    seed: int,
) -> int:
    """Give a place on the other side to everybody whom a newer crossing addresses; returns how many got one.

    So each dancer crosses once: what is remembered (memory (A, 3)) stays until another crossing addresses her.
    """
    claimed = 0
    for k in range(ROWS + active[CROSSING], ROWS + active[CROSSING + 1]):
        row = active[k]
        ax, az = float(vertices[row, 0, 0]), float(vertices[row, 0, 1])
        dx, dz = vertices[row, 1, 0] - ax, vertices[row, 1, 1] - az
        length = math.sqrt(dx * dx + dz * dz)
        nx, nz = dz / length, -dx / length
        new = 0
        for i in range(position.shape[0]):
            if (
                wants[i, PRESENCE] <= 0.0
                or memory[i, OWNER] >= table[row, SERIAL]
                or not addresses(masks[row], groups[i])
            ):
                continue
            x, z = float(position[i, 0]), float(position[i, 1])
            away = (x - ax) * nx + (z - az) * nz
            if abs(away) < 1e-4:  # on the line itself: to either side, by seeded chance
                away = hash_unit(seed, i, 55) - 0.5
            side = math.copysign(1.0, away)
            gx, gz = over_there(x, z, side, ax, az, nx, nz, half_width, half_depth)
            memory[i, OWNER], memory[i, GOAL_X], memory[i, GOAL_Z] = table[row, SERIAL], gx, gz
            new += 1
        if new:
            part_goals(memory, table[row, SERIAL], ax, az, nx, nz, half_width, half_depth, seed)
        claimed += new
    return claimed


@kernel("void(f8[:,::1],u8[::1],i4[::1],f4[:,::1],u8[::1],f8[:,::1],f8[::1],f8[:,::1])")
def cross_over(
    table: Float64,
    masks: UInt64,
    active: Int32,
    position: Float32,
    groups: UInt64,
    memory: Float64,
    numbers: Float64,
    sums: Float64,
) -> None:
    """Add the wish of those who cross over (T110): to her place on the other side, where she stays."""
    switched = numbers[SWITCHED] > 0.0
    for i in range(position.shape[0]):
        if sums[i, HEARD] <= 0.0:
            continue
        row = newest(table, masks, active, CROSSING, groups[i])
        if row < 0 or memory[i, OWNER] != table[row, SERIAL]:
            continue
        fx, fz = arrive(float(position[i, 0]), float(position[i, 1]), memory[i, GOAL_X], memory[i, GOAL_Z], SLOWING)
        size = table[row, LEVEL] * max(table[row, STRENGTH], 0.0)
        take(sums, i, size * fx, size * fz, table[row, LEVEL], switched)
