"""Effect of the elements on every agent: one pass over the agents for each acting kind (T083, T105-T110).

Behaviours are blended (a weighted sum, at most the top speed) or switched: urgent behaviours use their part of the
speed first, the others share the rest (Reynolds 1987: prioritized acceleration allocation).

Flow fields (T082) align the motion with the tangent of a uniform, radial, vortex, drawn or grid field.
"""

import math

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import FIRM, SPEED, VX, VZ
from live.agents.elements.audience_attractor_kernels import fair_attraction
from live.agents.elements.crossing_kernels import cross_over
from live.agents.elements.element_table_kernels import (
    ACTIVE_START,
    ADDRESSED_LEVEL,
    DECAY,
    FLOW_KIND,
    HALF_DEPTH,
    HALF_WIDTH,
    INFLUENCE,
    LEVEL,
    RADIUS,
    SLOT,
    STRENGTH,
    SUM_X,
    SUM_Z,
    SWITCHED,
    X,
    Z,
    add_velocity,
    addresses,
    reset_sums,
)
from live.agents.elements.leader_kernels import follow_leaders, pursue_or_evade
from live.agents.elements.shape_kernels import nearest_sources, signed_distance
from live.agents.elements.wander_kernels import follow_paths, spread_agents, wander_agents
from live.agents.steering_kernels import LOOK_AHEAD, flow_grid, flow_radial, flow_vortex, unit
from live.base.element_kinds import (
    ATTRACTOR,
    CROSSING,
    EVADE,
    FLOCK,
    FLOW,
    FOLLOW,
    PARTICIPANT,
    PATH,
    PURSUE,
    RADIAL,
    REPULSOR,
    SPREADER,
    UNIFORM,
    VORTEX,
    WANDER,
)
from live.base.jit import inline_kernel, kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
UInt64 = npt.NDArray[np.uint64]


@inline_kernel
def flow_at(
    table: Float64, vertices: Float32, grids: Float32, row: int, x: float, z: float, numbers: Float64
) -> tuple[float, float]:
    """Return the flow of one element at a place, before strength and level."""
    ax, az, kind = table[row, X], table[row, Z], int(table[row, FLOW_KIND])
    fx, fz = 0.0, 0.0
    if kind == UNIFORM:
        fx, fz = unit(vertices[row, 1, 0] - ax, vertices[row, 1, 1] - az)
    elif kind == RADIAL:
        fx, fz = flow_radial(x, z, ax, az, table[row, DECAY])
    elif kind == VORTEX:
        fx, fz = flow_vortex(x, z, ax, az, table[row, DECAY])
    elif table[row, SLOT] >= 0.0:
        fx, fz = flow_grid(grids, int(table[row, SLOT]), x, z, numbers[HALF_WIDTH], numbers[HALF_DEPTH])
    return fx, fz


@kernel(
    "void(f8[:,::1],u8[::1],f4[:,:,::1],i4[::1],f4[:,:,:,::1],f4[:,::1],f4[:,::1],u8[::1],f8[::1],f8[:,::1])",
)
def flow_fields(
    table: Float64,
    masks: UInt64,
    vertices: Float32,
    active: Int32,
    grids: Float32,
    position: Float32,
    velocity: Float32,
    groups: UInt64,
    numbers: Float64,
    sums: Float64,
) -> None:
    """Add the sum of all flows at each agent's predicted position; a radius limits a flow, with a soft border."""
    switched = numbers[SWITCHED] > 0.0
    for i in range(position.shape[0]):
        if sums[i, ADDRESSED_LEVEL] <= 0.0:
            continue
        x, z = position[i, 0] + velocity[i, 0] * LOOK_AHEAD, position[i, 1] + velocity[i, 1] * LOOK_AHEAD
        wish_x, wish_z, influence = 0.0, 0.0, 0.0
        for k in range(ACTIVE_START + active[FLOW], ACTIVE_START + active[FLOW + 1]):
            row = active[k]
            if not addresses(masks[row], groups[i]):
                continue
            fx, fz = flow_at(table, vertices, grids, row, x, z, numbers)
            level = table[row, LEVEL]
            if table[row, RADIUS] > 0.0:
                d, _, _ = signed_distance(table, vertices, row, x, z)
                level *= min(max(0.5 - d, 0.0), 1.0)
            wish_x += level * table[row, STRENGTH] * fx
            wish_z += level * table[row, STRENGTH] * fz
            influence = max(influence, level)
        add_velocity(sums, i, wish_x, wish_z, influence, switched)


AgentArrays = tuple[Float32, Float32, Float32, UInt64, Float64]
"""Position, velocity (A, 2), commands (A, 8), groups (A,) of the agents, targets of crossings (A, 3)."""
ElementArrays = tuple[Float64, UInt64, Float32, Int32, Float32, Float64, UInt64, Float64]
"""Table, masks, vertices, acting rows, grids of flows, the audience's places and masks, numbers of the call: as in
`ElementField`."""
MeshArrays = tuple[Float64, Float32, Int32, Int32, Float64]
"""Scratch of spreaders: area, mesh, starts, order, wanted velocity (A, 2)."""


@inline_kernel
def is_active(active: Int32, kind: int) -> bool:
    """Whether an element of a kind acts."""
    return bool(active[kind] < active[kind + 1])


@kernel("void(f4[:,::1],f8[:,::1],f4[::1])")
def blend_sums(commands: Float32, sums: Float64, influence: Float32) -> None:
    """Blend the sums over the plan: (1 - influence) of the plan plus the elements' velocity, at most the top speed."""
    for i in range(commands.shape[0]):
        influence[i] = 0.0
        if sums[i, ADDRESSED_LEVEL] <= 0.0:
            continue
        size = math.sqrt(sums[i, SUM_X] ** 2 + sums[i, SUM_Z] ** 2)
        scale, keep = commands[i, SPEED] / max(size, 1.0), 1.0 - sums[i, INFLUENCE]
        commands[i, VX] = keep * commands[i, VX] + scale * sums[i, SUM_X]
        commands[i, VZ] = keep * commands[i, VZ] + scale * sums[i, SUM_Z]
        commands[i, FIRM] *= keep
        influence[i] = sums[i, INFLUENCE]


@kernel(
    "void(Tuple((f4[:,::1],f4[:,::1],f4[:,::1],u8[::1],f8[:,::1])),"
    "Tuple((f8[:,::1],u8[::1],f4[:,:,::1],i4[::1],f4[:,:,:,::1],f8[:,::1],u8[::1],f8[::1])),"
    "Tuple((f8[::1],f4[:,::1],i4[::1],i4[:,::1],f8[:,::1])),f8[:,::1],f8[:,::1],f4[::1])"
)
def apply_elements(
    agents: AgentArrays,
    elements: ElementArrays,
    mesh_arrays: MeshArrays,
    sums: Float64,
    near: Float64,
    influence: Float32,
) -> None:
    """Blend all acting elements into the agents' commands, and write each agent's influence.

    sums (A, 5), near (A, 4): scratch; influence (A,), 0 to 1: 0 keeps the plan, 1 replaces it by the elements.
    """
    position, velocity, commands, groups, memory = agents
    table, masks, vertices, active, grids, places, audience, numbers = elements
    area, mesh, start, order, spreading = mesh_arrays
    reset_sums(table, masks, active, commands, groups, sums)
    if is_active(active, REPULSOR):
        nearest_sources(table, masks, vertices, active, REPULSOR, True, position, groups, numbers, sums, near)
    if is_active(active, EVADE):
        pursue_or_evade(table, masks, active, True, position, velocity, commands, groups, numbers, sums)
    if is_active(active, CROSSING):
        cross_over(table, masks, active, position, groups, memory, numbers, sums)
    if is_active(active, FOLLOW):
        follow_leaders(table, masks, active, position, velocity, commands, groups, numbers, sums)
    if is_active(active, PURSUE):
        pursue_or_evade(table, masks, active, False, position, velocity, commands, groups, numbers, sums)
    if is_active(active, PATH):
        follow_paths(table, masks, vertices, active, position, velocity, commands, groups, numbers, sums)
    if is_active(active, ATTRACTOR):
        nearest_sources(table, masks, vertices, active, ATTRACTOR, False, position, groups, numbers, sums, near)
    if is_active(active, PARTICIPANT):
        fair_attraction(places, audience, position, groups, numbers, sums)
    if is_active(active, FLOW):
        flow_fields(table, masks, vertices, active, grids, position, velocity, groups, numbers, sums)
    if is_active(active, SPREADER):
        spread_agents(
            table,
            masks,
            active,
            position,
            commands,
            groups,
            area,
            mesh,
            start,
            order,
            spreading,
            numbers,
            sums,
        )
    if is_active(active, WANDER) or is_active(active, FLOCK) or is_active(active, SPREADER):
        wander_agents(table, masks, active, position, velocity, groups, numbers, sums)
    blend_sums(commands, sums, influence)
