"""One tick of the crowd: cells, neighbours, motion, contacts, bounds."""

import numpy as np
import numpy.typing as npt

from live.agents.crowd.bounds_kernels import CAPACITY, bend_at_surroundings, keep_on_stage
from live.agents.crowd.cells_kernels import SLEEP, X, Z, asked_of, sort_agents
from live.agents.crowd.contacts_kernels import land_softly, part_bodies
from live.agents.crowd.motion_kernels import ask_agents, steer_agents
from live.agents.crowd.neighbour_kernels import sum_neighbours
from live.agents.crowd.reynolds_avoidance_kernels import avoid_by_distance
from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

ROWS, NUMBERS, CELL_ROWS, SPARE_COLUMNS = 32, 16, 2, 32
"""Rows of the scratch arrays `rows`, `numbers` and `cells`, and how many columns they have beyond the agents."""
_VELOCITY, _ACCELERATION, _REST, _HEED = 2, 4, 6, 7


@kernel("void(f4[::1], f4[::1], f4[::1], f4[:,::1], f4[:,::1], i4[::1], i8, f4[::1], f8)")
def finish_tick(
    out: Float32,
    state: Float32,
    wants: Float32,
    sorted_: Float32,
    moved: Float32,
    slot_agent: Int32,
    n: int,
    params: Float32,
    dt: float,
) -> None:
    """Write the new places and velocities; nobody leaves the stage but who passes, and who stands still grows sleepy.

    wants (8 A,): Wants.rows. The absent stay as they are, without velocity.
    """
    a = wants.shape[0] // 8
    v, acc, zero = _VELOCITY * a, _ACCELERATION * a, np.float32(0.0)
    tick, longest = np.float32(dt), np.float32(2.0 * SLEEP)
    for i in range(a if n < a else 0):
        if wants[8 * i + 7] <= zero:
            out[2 * i], out[2 * i + 1] = state[2 * i], state[2 * i + 1]
            out[v + 2 * i], out[v + 2 * i + 1], out[acc + 2 * i], out[acc + 2 * i + 1] = zero, zero, zero, zero
            out[_REST * a + i], out[_HEED * a + i] = zero, zero
    for s in range(n):
        i = slot_agent[s]
        x, z, vx, vz = moved[2, s], moved[3, s], moved[0, s], moved[1, s]
        if wants[8 * i + 7] < np.float32(2.0):
            limit_x, limit_z = max(params[0], abs(sorted_[X, s])), max(params[1], abs(sorted_[Z, s]))
            x, z = min(max(x, -limit_x), limit_x), min(max(z, -limit_z), limit_z)
        out[2 * i], out[2 * i + 1], out[v + 2 * i], out[v + 2 * i + 1] = x, z, vx, vz
        heed = asked_of(wants[8 * i + 3], wants[8 * i + 5])
        rested = zero
        if wants[8 * i] == zero and wants[8 * i + 1] == zero and state[_HEED * a + i] == heed:
            motion = abs(vx) + abs(vz) + abs(x - sorted_[X, s]) + abs(z - sorted_[Z, s])
            motion += abs(out[acc + 2 * i]) + abs(out[acc + 2 * i + 1])
            rested = min(state[_REST * a + i] + tick, longest) if motion == zero else zero
        out[_REST * a + i], out[_HEED * a + i] = rested, heed


@kernel("void(f4[::1], f4[::1], f4[::1], f4[:,::1], f4[::1], f8, f4[:,::1], i4[::1])")
def advance_crowd(
    out: Float32,
    state: Float32,
    fixed: Float32,
    wants: Float32,
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
    a, width = wants.shape[0], rows.shape[1]
    numbers = integers[: NUMBERS * width].reshape(NUMBERS, width)
    cells = integers[NUMBERS * width :].reshape(CELL_ROWS, (integers.shape[0] - NUMBERS * width) // CELL_ROWS)
    params = fixed[2 * a :]
    walls = surroundings[: 4 * CAPACITY].reshape(CAPACITY, 4)
    obstacles = surroundings[4 * CAPACITY : 9 * CAPACITY].reshape(CAPACITY, 5)
    wall_count, obstacle_count = int(surroundings[9 * CAPACITY]), int(surroundings[9 * CAPACITY + 1])
    grid = np.empty(4)
    wanted = wants.reshape(8 * a)
    sorted_, sums, moved, change = rows[0:6], rows[6:13], rows[13:17], rows[17:20]
    asks, asked = rows[20:24], rows[24:32].reshape(8 * width)[: 8 * a]
    slot_agent = numbers[0]
    pairs = numbers[4:16].reshape(12 * width)
    n = sort_agents(state, wanted, fixed[: 2 * a], sorted_, slot_agent, numbers[1:3].reshape(2 * width), cells, grid)
    ask_agents(asks, wanted, slot_agent, n, params)
    pair_count = sum_neighbours(
        sorted_, cells[0], grid, asks, sums, params, cells[1], numbers[1], numbers[2], numbers[3], pairs
    )
    if params[2] > 0.0:
        asked[:] = wanted
        avoid_by_distance(sorted_, cells[0], grid, asked, sums, slot_agent, params)
        steer_agents(out, state, asked, sums, moved, slot_agent, n, params, dt)
    else:
        steer_agents(out, state, wanted, sums, moved, slot_agent, n, params, dt)
    land_softly(moved, sorted_, pairs, pair_count, change, n, dt)
    if wall_count + obstacle_count > 0:
        bend_at_surroundings(moved, sorted_, n, walls, wall_count, obstacles, obstacle_count)
    keep_on_stage(moved, sorted_, wanted, slot_agent, n, params)
    for s in range(n):
        moved[2, s] = sorted_[X, s] + moved[0, s] * np.float32(dt)
        moved[3, s] = sorted_[Z, s] + moved[1, s] * np.float32(dt)
    part_bodies(moved, sorted_, pairs, pair_count, change, n, walls, wall_count, obstacles, obstacle_count)
    finish_tick(out, state, wanted, sorted_, moved, slot_agent, n, params, dt)
