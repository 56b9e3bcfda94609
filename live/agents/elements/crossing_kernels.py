"""Crossing behaviour (T110): each dancer's target on the other side of a line, fixed when the crossing begins."""

import math

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import PRESENCE
from live.agents.elements.element_table_kernels import (
    ACTIVE_START,
    ADDRESSED_LEVEL,
    LEVEL,
    SERIAL,
    STRENGTH,
    SWITCHED,
    add_velocity,
    addresses,
    newest,
)
from live.agents.steering_kernels import arrive, hash_unit
from live.base.element_kinds import CROSSING
from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
UInt64 = npt.NDArray[np.uint64]

# columns of the crossing memory of the agents (A, 3)
CROSSING_SERIAL, GOAL_X, GOAL_Z = 0, 1, 2
MEMORY_COLUMNS = 3

MIN_LINE_DISTANCE = 0.75
"""Smallest distance of a target from the line [m]."""
MIN_EDGE_DISTANCE = 0.45
"""Smallest distance of a target from the stage edge [m]."""
MIN_GOAL_DISTANCE = 0.75
"""Smallest distance of two targets [m]."""
SLOWING_DISTANCE = 1.0
"""Distance [m] from the target within which a dancer slows down."""
MAX_PAIR_TESTS = 3_000_000
"""Largest number of pairs compared when spacing targets; larger crowds rely on separation."""


@kernel("f8(f8,f8,f8,f8,f8,f8,f8)")
def side_depth(side: float, ax: float, az: float, nx: float, nz: float, half_width: float, half_depth: float) -> float:
    """Return the extent [m] of the stage on a side (+1, -1) of the line through (ax, az) with unit normal (nx, nz)."""
    corner = abs(nx) * half_width + abs(nz) * half_depth
    return corner - side * (ax * nx + az * nz)


@kernel("UniTuple(f8,2)(f8,f8,f8,f8,f8,f8,f8,f8,f8)")
def crossing_goal(
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
    """Return the target across the line for (x, z), which lies on `side` of it, along the same normal.

    If both sides are equally deep, it is the mirror image; otherwise the distance from the line scales with the depths.
    """
    own = max(side_depth(side, ax, az, nx, nz, half_width, half_depth), 0.1)
    other = max(side_depth(-side, ax, az, nx, nz, half_width, half_depth), 0.1)
    distance = side * ((x - ax) * nx + (z - az) * nz)
    way = distance + max(distance * other / own, MIN_LINE_DISTANCE)
    goal_x, goal_z = x - side * way * nx, z - side * way * nz
    edge_x, edge_z = max(half_width - MIN_EDGE_DISTANCE, 0.0), max(half_depth - MIN_EDGE_DISTANCE, 0.0)
    return min(max(goal_x, -edge_x), edge_x), min(max(goal_z, -edge_z), edge_z)


@kernel("void(f8[:,::1],f8,f8,f8,f8,f8,f8,f8,i8)")
def space_goals(
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
    """Space out the targets of a crossing that are too close, each on its side and on the stage."""
    agents = memory.shape[0]
    rounds = min(40, MAX_PAIR_TESTS // max(agents * agents, 1))
    edge_x, edge_z = max(half_width - MIN_EDGE_DISTANCE, 0.0), max(half_depth - MIN_EDGE_DISTANCE, 0.0)
    for _ in range(rounds):
        moved = False
        for i in range(agents):
            if memory[i, CROSSING_SERIAL] != owner:
                continue
            for j in range(i + 1, agents):
                if memory[j, CROSSING_SERIAL] != owner:
                    continue
                dx, dz = memory[j, GOAL_X] - memory[i, GOAL_X], memory[j, GOAL_Z] - memory[i, GOAL_Z]
                d2 = dx * dx + dz * dz
                if d2 >= (MIN_GOAL_DISTANCE - 0.01) ** 2:
                    continue
                d = math.sqrt(d2)
                if d < 1e-6:
                    angle = 2.0 * math.pi * hash_unit(seed, i, j)
                    dx, dz, d = 1e-6 * math.sin(angle), 1e-6 * math.cos(angle), 1e-6
                half = 0.5 * (MIN_GOAL_DISTANCE - d) / d
                memory[i, GOAL_X] -= half * dx
                memory[i, GOAL_Z] -= half * dz
                memory[j, GOAL_X] += half * dx
                memory[j, GOAL_Z] += half * dz
                moved = True
        if not moved:
            break
        for i in range(agents):
            if memory[i, CROSSING_SERIAL] == owner:
                gx = min(max(memory[i, GOAL_X], -edge_x), edge_x)
                gz = min(max(memory[i, GOAL_Z], -edge_z), edge_z)
                away = (gx - ax) * nx + (gz - az) * nz
                if abs(away) < MIN_LINE_DISTANCE:
                    push = math.copysign(MIN_LINE_DISTANCE, away) - away
                    gx, gz = gx + push * nx, gz + push * nz
                memory[i, GOAL_X] = min(max(gx, -edge_x), edge_x)
                memory[i, GOAL_Z] = min(max(gz, -edge_z), edge_z)


@kernel(
    "i8(f8[:,::1],u8[::1],f4[:,:,::1],i4[::1],f4[:,::1],f4[:,::1],u8[::1],f8[:,::1],f8,f8,i8)",
)
def assign_goals(
    table: Float64,
    masks: UInt64,
    vertices: Float32,
    active: Int32,
    position: Float32,
    commands: Float32,
    groups: UInt64,
    memory: Float64,
    half_width: float,
    half_depth: float,
    seed: int,
) -> int:
    """Assign a target on the other side to each dancer addressed by a newer crossing; return how many got one.

    Each dancer crosses once: the memory (A, 3) stays until another crossing addresses the dancer.
    """
    claimed = 0
    for k in range(ACTIVE_START + active[CROSSING], ACTIVE_START + active[CROSSING + 1]):
        row = active[k]
        ax, az = float(vertices[row, 0, 0]), float(vertices[row, 0, 1])
        dx, dz = vertices[row, 1, 0] - ax, vertices[row, 1, 1] - az
        length = math.sqrt(dx * dx + dz * dz)
        nx, nz = dz / length, -dx / length
        new = 0
        for i in range(position.shape[0]):
            if (
                commands[i, PRESENCE] <= 0.0
                or memory[i, CROSSING_SERIAL] >= table[row, SERIAL]
                or not addresses(masks[row], groups[i])
            ):
                continue
            x, z = float(position[i, 0]), float(position[i, 1])
            away = (x - ax) * nx + (z - az) * nz
            if abs(away) < 1e-4:  # on the line itself: a seeded random side
                away = hash_unit(seed, i, 55) - 0.5
            side = math.copysign(1.0, away)
            gx, gz = crossing_goal(x, z, side, ax, az, nx, nz, half_width, half_depth)
            memory[i, CROSSING_SERIAL], memory[i, GOAL_X], memory[i, GOAL_Z] = table[row, SERIAL], gx, gz
            new += 1
        if new:
            space_goals(memory, table[row, SERIAL], ax, az, nx, nz, half_width, half_depth, seed)
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
    """Add the crossing behaviour (T110): arrive at the target on the other side and stay."""
    switched = numbers[SWITCHED] > 0.0
    for i in range(position.shape[0]):
        if sums[i, ADDRESSED_LEVEL] <= 0.0:
            continue
        row = newest(table, masks, active, CROSSING, groups[i])
        if row < 0 or memory[i, CROSSING_SERIAL] != table[row, SERIAL]:
            continue
        fx, fz = arrive(
            float(position[i, 0]), float(position[i, 1]), memory[i, GOAL_X], memory[i, GOAL_Z], SLOWING_DISTANCE
        )
        size = table[row, LEVEL] * max(table[row, STRENGTH], 0.0)
        add_velocity(sums, i, size * fx, size * fz, table[row, LEVEL], switched)
