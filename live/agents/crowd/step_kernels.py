"""One tick of the crowd: cells, neighbours, motion, contacts, bounds.

Motion: each command becomes an acceleration, then a velocity within the agent's limits (T081, T083).

Agents are processed in blocks of BLOCK, as rows of numbers, so that the compiler vectorises each loop over a row: no
branches, no float64 and no calls inside such a loop.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.agents.crowd.contact_kernels import (
    CAPACITY,
    clamp_to_stage,
    deflect_velocities,
    limit_closing_speeds,
    resolve_overlaps,
    step_aside,
)
from live.agents.crowd.passage_kernels import PASSAGE_COLUMNS, PASSAGES, give_way
from live.agents.crowd.predictive_avoidance_kernels import sum_neighbours
from live.agents.crowd.reynolds_avoidance_kernels import avoid_by_distance
from live.agents.crowd.spatial_grid_kernels import (
    ALIGNMENT,
    AVOID_X,
    AVOID_Z,
    COHESION,
    FLOCK_X,
    FLOCK_Z,
    NEIGHBOUR_RANGE,
    PER_HORIZON,
    PER_SEPARATION2,
    PERSONAL,
    PUSH_X,
    PUSH_Z,
    RADIUS,
    SLEEP_TIME,
    WEIGHT,
    X,
    Z,
    neighbour_command_key,
    sort_agents,
)
from live.base.jit import inline_kernel, kernel

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

BLOCK = 32
SEPARATION_PEAK = 25.0 * math.sqrt(5.0) / 16.0
"""1 over the largest value of s (1 - s²)², which is at s = 1/√5."""
FIRM_HORIZON = 0.4
"""Look-ahead [s] of an agent with a firm command, whose path is planned."""
FIRM_AVOIDANCE_TIME = 0.25
"""Time [s] by which the avoidance acceleration of a firm agent is turned into velocity."""
# rows of a block: commands in the order of Wants.rows, sums in the order of the neighbour pass
_WANTS, _SUMS, _OLD, _AX, _AZ, _NEW_X, _NEW_Z, _BLOCK_ROWS = 0, 7, 14, 16, 17, 18, 19, 20
_WISH_X, _WISH_Z, _SPEED, _SEPARATION, _FIRM = 0, 1, 2, 3, 6

_F = np.float32
_ZERO: Any = _F(0.0)
_ONE: Any = _F(1.0)
_TINY: Any = _F(1e-6)
_STILL: Any = _F(1e-3)
_SLOW: Any = _F(0.1)
_PEAK: Any = _F(SEPARATION_PEAK)
_FIRM_AVOIDANCE_TIME: Any = _F(FIRM_AVOIDANCE_TIME)
_LEAST: Any = _F(1e-3)
_MOST: Any = _F(NEIGHBOUR_RANGE)
PERSONAL_GAP = 0.03
"""Gap between bodies [m] below which avoidance counts a meeting as a collision."""
_PERSONAL: Any = _F(PERSONAL_GAP)


@kernel("void(f4[:,::1], f4[:,::1], f4[::1], i4[::1], i8, f4[::1])")
def fill_requests(
    requests: Float32, sorted_: Float32, commands: Float32, slot_agent: Int32, n: int, params: Float32
) -> None:
    """Fill `requests`, the request of each sorted agent to the neighbour pass. `commands` (8 A,): AgentCommand.rows."""
    horizon, firm_horizon = params[6], _F(FIRM_HORIZON)
    for s in range(n):
        i = 8 * slot_agent[s]
        separation = min(max(commands[i + _SEPARATION], _LEAST), _MOST)
        ahead = horizon + commands[i + _FIRM] * (firm_horizon - horizon)
        requests[PER_SEPARATION2, s] = _ONE / (separation * separation)
        requests[PER_HORIZON, s] = _ONE / ahead
        requests[ALIGNMENT, s], requests[COHESION, s] = commands[i + 4], commands[i + 5]
        room = commands[i + _SEPARATION] - sorted_[RADIUS, s] - sorted_[RADIUS, s]
        close = commands[i + _SEPARATION] > _ZERO and room < _PERSONAL  # partners: asked to be nearer than that
        requests[PERSONAL, s] = _ZERO if close else _PERSONAL


@inline_kernel
def _gather_block(
    block: Float32, state: Float32, commands: Float32, sums: Float32, slot_agent: Int32, start: int, n: int
) -> None:
    """Copy the sorted agents from `start` on into the block; lanes beyond the last agent repeat it."""
    a = commands.shape[0] // 8
    for j in range(BLOCK):
        s = min(start + j, n - 1)
        i = slot_agent[s]
        for c in range(7):
            block[_WANTS + c, j] = commands[8 * i + c]
        for c in range(7):
            block[_SUMS + c, j] = sums[c, s]
        for c in range(2):
            block[_OLD + c, j] = state[2 * a + 2 * i + c]
            block[_AX + c, j] = state[4 * a + 2 * i + c]


@inline_kernel
def _accelerate(block: Float32, most: Any, per_relaxation: Any, catch_up: Any) -> None:
    """Compute accelerations: (desired - current velocity) (T081) over the relaxation time, plus avoidance."""
    for j in range(BLOCK):
        wish_x, wish_z, speed = block[_WISH_X, j], block[_WISH_Z, j], max(block[_SPEED, j], _ZERO)
        scale = min(speed / max(math.sqrt(wish_x * wish_x + wish_z * wish_z), _TINY), _ONE)
        wish_x, wish_z = wish_x * scale, wish_z * scale
        separation = block[_SEPARATION, j]
        scale = (_PEAK if separation > _ZERO else _ZERO) * speed / max(separation, _LEAST)
        push_x, push_z = block[_SUMS + PUSH_X, j] * scale, block[_SUMS + PUSH_Z, j] * scale
        scale = min(speed / max(math.sqrt(push_x * push_x + push_z * push_z), _TINY), _ONE)
        weight = max(block[_SUMS + WEIGHT, j] - _ONE, _ZERO)  # without the agent itself
        mean = (_ONE if weight > _LEAST else _ZERO) / max(weight, _LEAST)
        want_x = wish_x + push_x * scale + block[_SUMS + FLOCK_X, j] * mean
        want_z = wish_z + push_z * scale + block[_SUMS + FLOCK_Z, j] * mean
        scale = min(speed / max(math.sqrt(want_x * want_x + want_z * want_z), _TINY), _ONE)
        soft = (_ONE - block[_FIRM, j]) * per_relaxation
        ax = soft * (want_x * scale - block[_OLD, j]) + block[_SUMS + AVOID_X, j]
        az = soft * (want_z * scale - block[_OLD + 1, j]) + block[_SUMS + AVOID_Z, j]
        scale = min(most / max(math.sqrt(ax * ax + az * az), _TINY), _ONE) * catch_up
        ax = block[_AX, j] * (_ONE - catch_up) + ax * scale
        az = block[_AZ, j] * (_ONE - catch_up) + az * scale
        moving = _ONE if ax * ax + az * az > _STILL * _STILL else _ZERO
        block[_AX, j], block[_AZ, j] = ax * moving, az * moving
        block[_WISH_X, j], block[_WISH_Z, j] = wish_x, wish_z


@inline_kernel
def _integrate_velocity(block: Float32, most: Any, turn: Any, dt: Any) -> None:
    """Compute new velocities within top speed and turn rate; firm agents take the preferred velocity at once.

    `turn`: tangent of the largest turn. An agent brakes instead of turning further.
    """
    for j in range(BLOCK):
        old_x, old_z, speed = block[_OLD, j], block[_OLD + 1, j], max(block[_SPEED, j], _ZERO)
        old = math.sqrt(old_x * old_x + old_z * old_z)
        x, z = old_x + block[_AX, j] * dt, old_z + block[_AZ, j] * dt
        top = max(speed, old - most * dt)
        scale = min(top / max(math.sqrt(x * x + z * z), _TINY), _ONE)
        per_old = _ONE / max(old, _TINY)
        hx, hz = old_x * per_old, old_z * per_old
        along, across = (x * hx + z * hz) * scale, (z * hx - x * hz) * scale
        free = old < _SLOW
        along = along if free else max(along, _ZERO)
        side = _F(1e6) if free else along * turn
        across = min(max(across, -side), side)
        still = free and old < _TINY
        new_x = x * scale if still else along * hx - across * hz
        new_z = z * scale if still else along * hz + across * hx
        resting = block[_WISH_X, j] * block[_WISH_X, j] + block[_WISH_Z, j] * block[_WISH_Z, j] <= _ZERO
        asleep = resting and new_x * new_x + new_z * new_z < _STILL * _STILL and abs(block[_AX, j]) < _STILL
        keep = _ZERO if asleep else _ONE - block[_FIRM, j]
        firm = block[_FIRM, j]
        block[_NEW_X, j] = keep * new_x + firm * (block[_WISH_X, j] + _FIRM_AVOIDANCE_TIME * block[_AX, j])
        block[_NEW_Z, j] = keep * new_z + firm * (block[_WISH_Z, j] + _FIRM_AVOIDANCE_TIME * block[_AZ, j])


@kernel("void(f4[::1], f4[::1], f4[::1], f4[:,::1], f4[:,::1], i4[::1], i8, f4[::1], f8)")
def steer_agents(
    out: Float32,
    state: Float32,
    commands: Float32,
    sums: Float32,
    moved: Float32,
    slot_agent: Int32,
    n: int,
    params: Float32,
    dt: float,
) -> None:
    """Write new velocities of the n sorted agents into `moved` (rows 0, 1) and their accelerations into `out`.

    wants (8 A,): Wants.rows.
    """
    block = np.empty((_BLOCK_ROWS, BLOCK), np.float32)
    a = commands.shape[0] // 8
    most, per_relaxation = params[3], _F(1.0 / max(float(params[5]), dt))
    turn = _F(math.tan(min(float(params[4]) * dt, 1.5)))
    catch_up = _F(1.0 - math.exp(-dt / max(float(params[12]), 1e-6)))
    for start in range(0, n, BLOCK):
        _gather_block(block, state, commands, sums, slot_agent, start, n)
        _accelerate(block, most, per_relaxation, catch_up)
        _integrate_velocity(block, most, turn, _F(dt))
        for j in range(min(BLOCK, n - start)):
            s = start + j
            i = 4 * a + 2 * slot_agent[s]
            out[i], out[i + 1] = block[_AX, j], block[_AZ, j]
            moved[0, s], moved[1, s] = block[_NEW_X, j], block[_NEW_Z, j]


ROWS, NUMBERS, CELL_ROWS, SPARE_COLUMNS = 33, 16, 2, 32
"""Rows of the scratch arrays `rows`, `numbers` and `cells`, and their spare columns beyond the agents."""
_VELOCITY, _ACCELERATION, _REST, _REST_SEPARATION = 2, 4, 6, 7


@kernel("void(f4[::1], f4[::1], f4[::1], f4[:,::1], f4[:,::1], i4[::1], i8, f4[::1], f8)")
def finish_tick(
    out: Float32,
    state: Float32,
    commands: Float32,
    sorted_: Float32,
    moved: Float32,
    slot_agent: Int32,
    n: int,
    params: Float32,
    dt: float,
) -> None:
    """Write the new positions and velocities; clamp to the stage, except passing agents; count the resting time.

    wants (8 A,): Wants.rows. Absent agents keep their position, with zero velocity.
    """
    a = commands.shape[0] // 8
    v, acc, zero = _VELOCITY * a, _ACCELERATION * a, np.float32(0.0)
    tick, longest = np.float32(dt), np.float32(2.0 * SLEEP_TIME)
    for i in range(a if n < a else 0):
        if commands[8 * i + 7] <= zero:
            out[2 * i], out[2 * i + 1] = state[2 * i], state[2 * i + 1]
            out[v + 2 * i], out[v + 2 * i + 1], out[acc + 2 * i], out[acc + 2 * i + 1] = zero, zero, zero, zero
            out[_REST * a + i], out[_REST_SEPARATION * a + i] = zero, zero
    for s in range(n):
        i = slot_agent[s]
        x, z, vx, vz = moved[2, s], moved[3, s], moved[0, s], moved[1, s]
        if commands[8 * i + 7] < np.float32(2.0):
            limit_x, limit_z = max(params[0], abs(sorted_[X, s])), max(params[1], abs(sorted_[Z, s]))
            x, z = min(max(x, -limit_x), limit_x), min(max(z, -limit_z), limit_z)
        out[2 * i], out[2 * i + 1], out[v + 2 * i], out[v + 2 * i + 1] = x, z, vx, vz
        heed = neighbour_command_key(commands[8 * i + 3], commands[8 * i + 5])
        rested = zero
        if commands[8 * i] == zero and commands[8 * i + 1] == zero and state[_REST_SEPARATION * a + i] == heed:
            motion = abs(vx) + abs(vz) + abs(x - sorted_[X, s]) + abs(z - sorted_[Z, s])
            motion += abs(out[acc + 2 * i]) + abs(out[acc + 2 * i + 1])
            rested = min(state[_REST * a + i] + tick, longest) if motion == zero else zero
        out[_REST * a + i], out[_REST_SEPARATION * a + i] = rested, heed


@kernel("void(f4[::1], f4[::1], f4[::1], f4[:,::1], f4[::1], f8, f4[:,::1], i4[::1])")
def advance_crowd(
    out: Float32,
    state: Float32,
    fixed: Float32,
    commands: Float32,
    surroundings: Float32,
    dt: float,
    rows: Float32,
    integers: Int32,
) -> None:
    """Advance all agents by dt [s] from `state` to `out` (8 A,), in the order of AgentState.flat.

    fixed (2 A + 13,): radius and responsibility of each agent, then Steering.vector(); wants (A, 8): Wants.rows;
    surroundings: Surroundings.flat; scratch: rows (ROWS, A + SPARE_COLUMNS), integers: NUMBERS rows as long, then
    CELL_ROWS rows of the number of cells + 2.
    """
    a, width = commands.shape[0], rows.shape[1]
    numbers = integers[: NUMBERS * width].reshape(NUMBERS, width)
    cells = integers[NUMBERS * width :].reshape(CELL_ROWS, (integers.shape[0] - NUMBERS * width) // CELL_ROWS)
    params = fixed[2 * a :]
    walls = surroundings[: 4 * CAPACITY].reshape(CAPACITY, 4)
    obstacles = surroundings[4 * CAPACITY : 9 * CAPACITY].reshape(CAPACITY, 5)
    wall_count, obstacle_count = int(surroundings[9 * CAPACITY]), int(surroundings[9 * CAPACITY + 1])
    grid = np.empty(4)
    wanted = commands.reshape(8 * a)
    sorted_, sums, moved, change = rows[0:6], rows[6:13], rows[13:17], rows[17:20]
    asks, asked = rows[20:25], rows[25:33].reshape(8 * width)[: 8 * a]
    slot_agent = numbers[0]
    pairs = numbers[4:16].reshape(12 * width)
    n = sort_agents(state, wanted, fixed[: 2 * a], sorted_, slot_agent, numbers[1:3].reshape(2 * width), cells, grid)
    passage_count = int(surroundings[9 * CAPACITY + 2])
    if passage_count > 0 or params[2] > 0.0:
        for k in range(8 * a):
            asked[k] = wanted[k]
        wanted = asked
    if passage_count > 0:
        passages = surroundings[9 * CAPACITY + 3 :].reshape(PASSAGES, PASSAGE_COLUMNS)
        give_way(wanted, sorted_, slot_agent, n, passages, passage_count)
    fill_requests(asks, sorted_, wanted, slot_agent, n, params)
    pair_count = sum_neighbours(
        sorted_, cells[0], grid, asks, sums, params, cells[1], numbers[1], numbers[2], numbers[3], pairs
    )
    if params[2] > 0.0:
        avoid_by_distance(sorted_, cells[0], grid, wanted, sums, slot_agent, params)
    steer_agents(out, state, wanted, sums, moved, slot_agent, n, params, dt)
    step_aside(moved, sorted_, wanted, slot_agent, pairs, pair_count, dt)
    limit_closing_speeds(moved, sorted_, pairs, pair_count, change, n, dt)
    if wall_count + obstacle_count > 0:
        deflect_velocities(moved, sorted_, n, walls, wall_count, obstacles, obstacle_count)
    clamp_to_stage(moved, sorted_, wanted, slot_agent, n, params)
    for s in range(n):
        moved[2, s] = sorted_[X, s] + moved[0, s] * np.float32(dt)
        moved[3, s] = sorted_[Z, s] + moved[1, s] * np.float32(dt)
    resolve_overlaps(moved, sorted_, pairs, pair_count, change, n, walls, wall_count, obstacles, obstacle_count)
    finish_tick(out, state, wanted, sorted_, moved, slot_agent, n, params, dt)
