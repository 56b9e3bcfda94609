"""Kernels that prepare and post-process agent commands: reset, speed limits, presence and the leash to the dancers."""

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import ALIGNMENT, COHESION, FIRM, PRESENCE, SEPARATION, SPEED, VX, VZ
from live.agents.separation.separation_kernels import tether_agents
from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]
Int8 = npt.NDArray[np.int8]


@kernel("void(f4[:,::1], f4[::1], f4)")
def reset_commands(rows: Float32, speed: Float32, separation: float) -> None:
    """Reset all commands except presence; set the speed limit to `speed` (A,) [m/s] and the separation to `separation`
    [m].

    `rows` (A, 8) as in `AgentCommand`.
    """
    zero = np.float32(0.0)
    for n in range(rows.shape[0]):
        rows[n, VX], rows[n, VZ], rows[n, ALIGNMENT], rows[n, COHESION], rows[n, FIRM] = zero, zero, zero, zero, zero
        rows[n, SPEED], rows[n, SEPARATION] = speed[n], separation


@kernel("void(f4[:,::1], f4[::1], f4)")
def raise_firm_speeds(rows: Float32, speed: Float32, factor: float) -> None:
    """Raise the speed limit of agents with a firm command to `times` times `speed` (A,) [m/s]."""
    for n in range(rows.shape[0]):
        if rows[n, FIRM] > 0.0:
            rows[n, SPEED] = speed[n] * factor


@kernel("i8(f4[:,::1], i1[::1], f4[::1], f4)")
def write_presence(rows: Float32, state: Int8, presence: Float32, counted: float) -> int:
    """Write `presence` (S,) of each agent's `state` (A,) into `rows` (A, 8); return the number of `passing` ones."""
    count = 0
    for n in range(rows.shape[0]):
        rows[n, PRESENCE] = presence[state[n]]
        count += rows[n, PRESENCE] == counted
    return count


@kernel("b1(i4[::1], i4[::1])")
def same_indices(first: Int32, second: Int32) -> bool:
    """Whether two arrays (A,) are equal."""
    different = False
    for n in range(first.shape[0]):
        different |= first[n] != second[n]
    return not different


@kernel("b1(i1[::1], i8)")
def any_agent_in(state: Int8, wanted: int) -> bool:
    """Whether any agent's `state` (A,) equals `wanted`."""
    found = False
    for n in range(state.shape[0]):
        found |= state[n] == wanted
    return found


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

    Agents with state `on` use the distance `leash` [m], other visible agents (state >= `seen`) use `long_leash` [m].
    Agents with a firm command (`rows` (A, 8)) are not bound. `most` (A,) is scratch.
    """
    for n in range(state.shape[0]):
        max_distance[n] = np.inf
        if state[n] >= first_visible and rows[n, FIRM] <= 0.0:
            max_distance[n] = leash if state[n] == on_stage else long_leash
    tether_agents(position, velocity, dancer, pace, max_distance)
