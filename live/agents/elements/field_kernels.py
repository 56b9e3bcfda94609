"""Flow fields, and the blend of all elements' wishes over the plan (T083, T105-T110).

Flow fields (T082) align the motion with the tangent of a uniform, radial, vortex, drawn or grid field.
"""

import math

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import FIRM, SPEED, VX, VZ
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
)
from live.agents.elements.shape_kernels import signed_distance
from live.agents.steering_kernels import LOOK_AHEAD, flow_grid, flow_radial, flow_vortex, unit
from live.base.element_kinds import FLOW, RADIAL, UNIFORM, VORTEX
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
