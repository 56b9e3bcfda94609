"""One tick of the crowd: cells, neighbours, motion, contacts, bounds."""

import numpy as np
import numpy.typing as npt

from live.agents.crowd.bounds.kernels import bend_at_surroundings, keep_on_stage
from live.agents.crowd.cells.kernels import sort_agents
from live.agents.crowd.contacts.kernels import land_softly, part_bodies
from live.agents.crowd.motion.kernels import ask_agents, steer_agents
from live.agents.crowd.neighbours.kernels import sum_neighbours
from live.agents.crowd.thesis.kernels import avoid_by_distance
from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]


@kernel(
    "void(f4[::1], f4[::1], f4[:,::1], f4[:,::1], f4[:,::1], i8, f4[:,::1], i8, f4[::1], i8, f8, f8, f4[:,::1], i4[:,::1], i4[::1])"
)
def advance_crowd(
    out: Float32,
    state: Float32,
    model: Float32,
    wants: Float32,
    walls: Float32,
    wall_count: int,
    obstacles: Float32,
    obstacle_count: int,
    params: Float32,
    seed: int,
    time: float,
    dt: float,
    rows: Float32,
    numbers: Int32,
    start: Int32,
) -> None:
    """Advance all agents by dt [s] from `state` to `out` (8 A,).

    model (A, 2): radius, responsibility; wants (A, 8); rows (32, A), numbers (16, A), start: scratch.
    """
    a = wants.shape[0]
    wanted = wants.reshape(8 * a)
    grid = np.empty(4)
    sorted_, sums, moved, change, asks = rows[0:6], rows[6:14], rows[14:18], rows[18:21], rows[26:31]
    slot_agent = numbers[0]
    pairs = numbers[4:16].reshape(12 * numbers.shape[1])
    n = sort_agents(state, wants, model, sorted_, slot_agent, numbers[1:3].reshape(2 * numbers.shape[1]), start, grid)
    ask_agents(asks, wanted, slot_agent, n, params)
    pair_count = sum_neighbours(sorted_, start, grid, asks, sums, params, rows[31:37], numbers[16], numbers[17], pairs)
    if params[2] > 0.0:
        asked = rows[37:45].reshape(8 * rows.shape[1])[: 8 * a]
        asked[:] = wanted
        avoid_by_distance(sorted_, start, grid, asked, sums, slot_agent, params)
        wanted = asked
    steer_agents(out, state, wanted, sums, moved, slot_agent, n, params, dt)
    land_softly(moved, sorted_, pairs, pair_count, change, n, dt)
    bend_at_surroundings(moved, sorted_, n, walls, wall_count, obstacles, obstacle_count)
    keep_on_stage(moved, sorted_, wants, slot_agent, n, params)
    for s in range(n):
        moved[2, s] = sorted_[0, s] + moved[0, s] * np.float32(dt)
        moved[3, s] = sorted_[1, s] + moved[1, s] * np.float32(dt)
    part_bodies(moved, sorted_, pairs, pair_count, change, n, walls, wall_count, obstacles, obstacle_count)
    for i in range(a):
        if wants[i, 7] <= 0.0:
            for k in range(2):
                out[2 * i + k], out[2 * a + 2 * i + k], out[4 * a + 2 * i + k] = state[2 * i + k], 0.0, 0.0
            out[6 * a + i], out[7 * a + i] = 0.0, 0.0
    for s in range(n):
        i = slot_agent[s]
        x, z = float(moved[2, s]), float(moved[3, s])
        if wants[i, 7] < 2.0:
            limit = max(params[0], abs(sorted_[0, s]))
            x = min(max(x, -limit), limit)
            limit = max(params[1], abs(sorted_[1, s]))
            z = min(max(z, -limit), limit)
        out[2 * i], out[2 * i + 1] = x, z
        out[2 * a + 2 * i], out[2 * a + 2 * i + 1] = moved[0, s], moved[1, s]
        out[6 * a + i], out[7 * a + i] = 0.0, 0.0
