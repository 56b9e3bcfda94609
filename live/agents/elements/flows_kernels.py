"""Flow fields (T082): align the motion with the tangent of a field, here uniform, radial, a vortex, drawn or a grid."""

import numpy as np
import numpy.typing as npt

from live.agents.elements.element_kinds import FLOW, RADIAL, UNIFORM, VORTEX
from live.agents.elements.shape_kernels import seen_from
from live.agents.elements.table_kernels import (
    DECAY,
    FLOW_KIND,
    HALF_DEPTH,
    HALF_WIDTH,
    HEARD,
    LEVEL,
    RADIUS,
    ROWS,
    SLOT,
    STRENGTH,
    SWITCHED,
    X,
    Z,
    addresses,
    take,
)
from live.agents.steering_kernels import LOOK, flow_grid, flow_radial, flow_vortex, unit
from live.base.jit import kernel, part

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
UInt64 = npt.NDArray[np.uint64]


@part
def flow_at(
    table: Float64, vertices: Float32, grids: Float32, row: int, x: float, z: float, numbers: Float64
) -> tuple[float, float]:
    """The flow of one element at a place, before strength and level."""
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
    """Add the sum of all flows where each agent will be in a moment; one with a radius acts only within it, softly."""
    switched = numbers[SWITCHED] > 0.0
    for i in range(position.shape[0]):
        if sums[i, HEARD] <= 0.0:
            continue
        x, z = position[i, 0] + velocity[i, 0] * LOOK, position[i, 1] + velocity[i, 1] * LOOK
        wish_x, wish_z, influence = 0.0, 0.0, 0.0
        for k in range(ROWS + active[FLOW], ROWS + active[FLOW + 1]):
            row = active[k]
            if not addresses(masks[row], groups[i]):
                continue
            fx, fz = flow_at(table, vertices, grids, row, x, z, numbers)
            level = table[row, LEVEL]
            if table[row, RADIUS] > 0.0:
                d, _, _ = seen_from(table, vertices, row, x, z)
                level *= min(max(0.5 - d, 0.0), 1.0)
            wish_x += level * table[row, STRENGTH] * fx
            wish_z += level * table[row, STRENGTH] * fz
            influence = max(influence, level)
        take(sums, i, wish_x, wish_z, influence, switched)
