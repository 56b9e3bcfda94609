"""Leader following, pursuit and evasion (T082; Reynolds 1999): elements that target another dancer."""

import math

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import PRESENCE, SPEED
from live.agents.elements.element_table_kernels import (
    ACTIVE_START,
    ADDRESSED_LEVEL,
    DECAY,
    LEVEL,
    RADIUS,
    STRENGTH,
    SWITCHED,
    TARGET,
    TARGET_GROUP,
    WEDGE,
    add_velocity,
    addresses,
    newest,
)
from live.agents.steering_kernels import clear_path, evade, follow_behind, follow_in_wedge, pursue, unit
from live.base.element_kinds import EVADE, FOLLOW, PURSUE
from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
UInt64 = npt.NDArray[np.uint64]

FOLLOW_DISTANCE = 0.9
"""Default distance between followers [m], if the element has no radius."""
MAX_CANDIDATES = 64
"""Largest number of dancers of a group searched for the nearest."""


@kernel("i8(f4[:,::1],u8[::1],i8,i8)")
def first_target(commands: Float32, groups: UInt64, target: int, target_group: int) -> int:
    """Return the target dancer, or the first present dancer of a group; -1: none."""
    if target >= 0:
        return target if target < groups.shape[0] and commands[target, PRESENCE] > 0.0 else -1
    bit = np.uint64(1) << np.uint64(target_group)
    for i in range(groups.shape[0]):
        if commands[i, PRESENCE] > 0.0 and (groups[i] & bit) != np.uint64(0):
            return i
    return -1


@kernel("i8(f4[:,::1],f4[:,::1],u8[::1],i8,i8,i8)")
def nearest_target(
    position: Float32, commands: Float32, groups: UInt64, target: int, target_group: int, agent: int
) -> int:
    """Return the target dancer, or the nearest one of a group, never the agent itself; -1: none."""
    if target >= 0:
        meant = target < groups.shape[0] and target != agent and commands[target, PRESENCE] > 0.0
        return target if meant else -1
    bit = np.uint64(1) << np.uint64(target_group)
    best, nearest, seen = -1, 1e30, 0
    for i in range(groups.shape[0]):
        if i == agent or commands[i, PRESENCE] <= 0.0 or (groups[i] & bit) == np.uint64(0):
            continue
        d2 = (position[i, 0] - position[agent, 0]) ** 2 + (position[i, 1] - position[agent, 1]) ** 2
        if d2 < nearest:
            best, nearest = i, d2
        seen += 1
        if seen == MAX_CANDIDATES:
            break
    return best


@kernel("void(f8[:,::1],u8[::1],i4[::1],i8,f4[:,::1],f4[:,::1],f4[:,::1],u8[::1],i8,f8[:,::1],b1)")
def follow_one(
    table: Float64,
    masks: UInt64,
    active: Int32,
    row: int,
    position: Float32,
    velocity: Float32,
    commands: Float32,
    groups: UInt64,
    leader: int,
    sums: Float64,
    switched: bool,
) -> None:
    """Add the velocity of the followers of `leader` for element `row`, in index order.

    In a line each dancer follows the previous one; in a wedge the previous one on the same side, along the leader's
    heading (towards the audience while the leader stands). Followers clear the leader's path.
    """
    hx, hz = unit(float(velocity[leader, 0]), velocity[leader, 1] + 0.05)
    gap = table[row, RADIUS] if table[row, RADIUS] > 0.0 else FOLLOW_DISTANCE
    last, last_but_one, side = leader, leader, 1.0
    level, strength = table[row, LEVEL], table[row, STRENGTH]
    for i in range(position.shape[0]):
        if sums[i, ADDRESSED_LEVEL] <= 0.0 or i == leader or newest(table, masks, active, FOLLOW, groups[i]) != row:
            continue
        x, z = float(position[i, 0]), float(position[i, 1])
        if table[row, WEDGE] > 0.0:
            bx, bz = float(position[last_but_one, 0]), float(position[last_but_one, 1])
            fx, fz = follow_in_wedge(x, z, bx, bz, hx, hz, side, gap)
        else:
            bx, bz = float(position[last, 0]), float(position[last, 1])
            fx, fz = follow_behind(x, z, bx, bz, float(velocity[last, 0]), float(velocity[last, 1]), gap)
        wx, wz = clear_path(
            x,
            z,
            float(position[leader, 0]),
            float(position[leader, 1]),
            float(velocity[leader, 0]),
            float(velocity[leader, 1]),
        )
        add_velocity(sums, i, level * (strength * fx + wx), level * (strength * fz + wz), level, switched)
        last_but_one, last, side = last, i, -side


@kernel("void(f8[:,::1],u8[::1],i4[::1],f4[:,::1],f4[:,::1],f4[:,::1],u8[::1],f8[::1],f8[:,::1])")
def follow_leaders(
    table: Float64,
    masks: UInt64,
    active: Int32,
    position: Float32,
    velocity: Float32,
    commands: Float32,
    groups: UInt64,
    numbers: Float64,
    sums: Float64,
) -> None:
    """Add the velocity of all followers; each obeys the newest element that addresses it."""
    for k in range(ACTIVE_START + active[FOLLOW], ACTIVE_START + active[FOLLOW + 1]):
        row = active[k]
        leader = first_target(commands, groups, int(table[row, TARGET]), int(table[row, TARGET_GROUP]))
        if leader >= 0:
            follow_one(
                table, masks, active, row, position, velocity, commands, groups, leader, sums, numbers[SWITCHED] > 0.0
            )


@kernel("void(f8[:,::1],u8[::1],i4[::1],b1,f4[:,::1],f4[:,::1],f4[:,::1],u8[::1],f8[::1],f8[:,::1])")
def pursue_or_evade(
    table: Float64,
    masks: UInt64,
    active: Int32,
    flees: bool,
    position: Float32,
    velocity: Float32,
    commands: Float32,
    groups: UInt64,
    numbers: Float64,
    sums: Float64,
) -> None:
    """Add the velocity of pursuers (of their newest quarry) and evaders (from all hunters together, f of T105)."""
    kind = EVADE if flees else PURSUE
    for i in range(position.shape[0]):
        if sums[i, ADDRESSED_LEVEL] <= 0.0:
            continue
        wish_x, wish_z, influence = 0.0, 0.0, 0.0
        x, z, speed = float(position[i, 0]), float(position[i, 1]), float(commands[i, SPEED])
        for k in range(ACTIVE_START + active[kind + 1] - 1, ACTIVE_START + active[kind] - 1, -1):
            row = active[k]
            if not addresses(masks[row], groups[i]):
                continue
            j = nearest_target(position, commands, groups, int(table[row, TARGET]), int(table[row, TARGET_GROUP]), i)
            if j < 0:
                continue
            jx, jz, level = float(position[j, 0]), float(position[j, 1]), table[row, LEVEL]
            jvx, jvz = float(velocity[j, 0]), float(velocity[j, 1])
            if flees:
                fx, fz = evade(x, z, jx, jz, jvx, jvz, speed)
                level *= math.exp(-math.sqrt((jx - x) ** 2 + (jz - z) ** 2) / table[row, DECAY])
            else:
                fx, fz = pursue(x, z, jx, jz, jvx, jvz, speed)
            wish_x += level * table[row, STRENGTH] * fx
            wish_z += level * table[row, STRENGTH] * fz
            influence = max(influence, level)
            if not flees:
                break
        add_velocity(sums, i, wish_x, wish_z, influence, numbers[SWITCHED] > 0.0)
