"""Kernels that prepare and post-process agent commands: reset, speed limits, presence and the leash to the dancers."""

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import FIRM, PRESENCE
from live.agents.separation.separation_kernels import tether_agents
from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]
Int8 = npt.NDArray[np.int8]


@kernel("i8(f4[:,::1], i1[::1], f4[::1], f4)")
def write_presence(rows: Float32, state: Int8, presence: Float32, counted: float) -> int:
    """Write `presence` (S,) of each agent's `state` (A,) into `rows` (A, 8); return the number of `counted` ones."""
    count = 0
    for n in range(rows.shape[0]):
        rows[n, PRESENCE] = presence[state[n]]
        count += rows[n, PRESENCE] == counted
    return count


@kernel("void(f4[:,::1], f4[:,::1], f4[:,::1], f4[:,::1], f4[:,::1], i1[::1], i8, i8, f4, f4, f4[::1])")
def hold_on_leash(
    position: Float32,
    velocity: Float32,
    dancer: Float32,
    pace: Float32,
    rows: Float32,
    state: Int8,
    first_visible: int,
    on_stage: int,
    leash: float,
    long_leash: float,
    max_distance: Float32,
) -> None:
    """Bind agents to their dancers as `tether_agents` does.

    Agents with state `on_stage` use the distance `leash` [m], other visible agents (state >= `first_visible`) use
    `long_leash` [m]. Agents with a firm command (`rows` (A, 8)) are not bound. `max_distance` (A,) is scratch.
    """
    for n in range(state.shape[0]):
        max_distance[n] = np.inf
        if state[n] >= first_visible and rows[n, FIRM] <= 0.0:
            max_distance[n] = leash if state[n] == on_stage else long_leash
    tether_agents(position, velocity, dancer, pace, max_distance)
