"""Element shapes (point, line, region) as signed distance and direction, and force laws."""

import math

import numpy as np
import numpy.typing as npt

from live.agents.elements.element_table_kernels import (
    ACTIVE_START,
    ADDRESSED_LEVEL,
    CLOSED,
    CORNERS,
    DECAY,
    LEVEL,
    RADIUS,
    SEED,
    STRENGTH,
    SWITCHED,
    X,
    Z,
    add_velocity,
    addresses,
)
from live.agents.steering_kernels import hash_unit, nearest_on_line
from live.base.jit import inline_kernel, kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
UInt64 = npt.NDArray[np.uint64]


REGION_INSET = 0.35
"""Depth [m] to which regions attract dancers, so that they do not stop on the border."""

# columns of the nearest source of an agent (A, 4)
NEAR_DISTANCE, NEAR_ROW, NEAR_X, NEAR_Z = 0, 1, 2, 3
NEAR_COLUMNS = 4
FADING = 4
"""Most sources that act while the nearest one fades."""
SQUARE_ROUNDING = 1.0 + 1e-9
"""Squares of distances differ by less than this factor from the distances that are compared."""


@kernel("b1(f4[:,:,::1],i8,i8,f8,f8)")
def in_polygon(vertices: Float32, row: int, count: int, x: float, z: float) -> bool:
    """Whether (x, z) lies in the polygon of a row of `vertices` (E, V, 2), by the even-odd rule."""
    within = False
    before = count - 1
    for v in range(count):
        ax, az = vertices[row, v, 0], vertices[row, v, 1]
        bx, bz = vertices[row, before, 0], vertices[row, before, 1]
        if (az > z) != (bz > z) and x < ax + (z - az) / (bz - az) * (bx - ax):
            within = not within
        before = v
    return within


@kernel("UniTuple(f8,3)(f8[:,::1],f4[:,:,::1],i8,f8,f8)")
def signed_distance(table: Float64, vertices: Float32, row: int, x: float, z: float) -> tuple[float, float, float]:
    """Return the signed distance [m] from (x, z) to an element's shape, negative inside, and the unit vector to its
    border.

    The vector is (0, 0) on the border or point itself.
    """
    corners = int(table[row, CORNERS])
    radius = table[row, RADIUS]
    within = False
    if corners == 1:
        dx, dz = table[row, X] - x, table[row, Z] - z
        d = math.sqrt(dx * dx + dz * dz)
    else:
        closed = table[row, CLOSED] > 0.0
        d2, px, pz, _, _ = nearest_on_line(vertices, row, corners, closed, x, z, 0.0, 0.0)
        dx, dz, d = px - x, pz - z, math.sqrt(d2)
        within = closed and in_polygon(vertices, row, corners, x, z)
    if d < 1e-6:
        dx, dz = 0.0, 0.0
    else:
        dx, dz = dx / d, dz / d
    if within:  # the radius extends a polygon beyond its border
        return -d - radius, dx, dz
    d -= radius
    if d < 0.0:  # in a disc or a broad line the border lies away from its middle
        return d, -dx, -dz
    return d, dx, dz


@kernel("UniTuple(f8,3)(f8,f8,f8,f8,f8,f8)")
def attraction(
    d: float, to_x: float, to_z: float, inset: float, strength: float, decay: float
) -> tuple[float, float, float]:
    """Return the velocity towards a source at distance `d` [m], 1 - exp(-d / decay) (T105), and influence 1.

    Fast far away, slow on arrival. A region attracts until the agent is `inset` [m] inside.
    """
    depth = d + inset
    if depth <= 0.0:
        return 0.0, 0.0, 1.0
    size = strength * (1.0 - math.exp(-depth / decay))
    if d < 0.0:  # inside, the border lies behind the agent
        return -size * to_x, -size * to_z, 1.0
    return size * to_x, size * to_z, 1.0


@kernel("UniTuple(f8,3)(f8,f8,f8,f8,f8)")
def repulsion(d: float, to_x: float, to_z: float, strength: float, decay: float) -> tuple[float, float, float]:
    """Return the velocity away from a source at distance `d` [m], exp(-d / decay) (T105), out of a region if inside,
    and its magnitude.
    """
    if d <= 0.0:
        return strength * to_x, strength * to_z, 1.0
    size = strength * math.exp(-d / decay)
    return -size * to_x, -size * to_z, min(abs(size), 1.0)


@inline_kernel
def find_nearest(
    table: Float64,
    masks: UInt64,
    vertices: Float32,
    active: Int32,
    kind: int,
    x: float,
    z: float,
    groups: np.uint64,
    found: Float64,
) -> int:
    """Write the sources of a kind that are nearest to (x, z) into `found` (FADING, 4), in order: distance, row and unit
    vector to it; of equal ones the lower row comes first. Return how many there are."""
    count, largest = 0, 1e60
    for k in range(ACTIVE_START + active[kind], ACTIVE_START + active[kind + 1]):
        row = int(active[k])
        if not addresses(masks[row], groups):
            continue
        if table[row, CORNERS] == 1.0 and table[row, RADIUS] == 0.0:
            ux, uz = table[row, X] - x, table[row, Z] - z
            square = ux * ux + uz * uz
            if square > largest:  # most rows: no root, no division
                continue
            d = math.sqrt(square)
            scale = 1.0 / d if d > 1e-6 else 0.0
            ux, uz = ux * scale, uz * scale
        else:
            d, ux, uz = signed_distance(table, vertices, row, x, z)
        if count == FADING and d >= found[FADING - 1, NEAR_DISTANCE]:
            continue
        count = min(count + 1, FADING)
        place = count - 1
        while place > 0 and d < found[place - 1, NEAR_DISTANCE]:
            for c in range(NEAR_COLUMNS):
                found[place, c] = found[place - 1, c]
            place -= 1
        found[place, NEAR_DISTANCE], found[place, NEAR_ROW] = d, row
        found[place, NEAR_X], found[place, NEAR_Z] = ux, uz
        if count == FADING and found[FADING - 1, NEAR_DISTANCE] > 0.0:
            largest = found[FADING - 1, NEAR_DISTANCE] ** 2 * SQUARE_ROUNDING
    return count


@inline_kernel
def source_velocity(
    table: Float64, row: int, repels: bool, d: float, to_x: float, to_z: float, seed: int, agent: int
) -> tuple[float, float, float]:
    """Return velocity and influence of one source at distance `d`, before its level."""
    if to_x == 0.0 and to_z == 0.0:  # on the spot itself: a seeded random direction
        angle = 2.0 * math.pi * hash_unit(seed, agent, 77)
        to_x, to_z = math.sin(angle), math.cos(angle)
    if repels:
        fx, fz, asked = repulsion(d, to_x, to_z, table[row, STRENGTH], table[row, DECAY])
    else:
        inset = min(REGION_INSET, table[row, RADIUS] if table[row, CLOSED] == 0.0 else REGION_INSET)
        fx, fz, asked = attraction(d, to_x, to_z, inset, table[row, STRENGTH], table[row, DECAY])
    return fx, fz, asked


@kernel("UniTuple(f8,3)(f8[:,::1],u8[::1],f4[:,:,::1],i4[::1],i8,b1,f8,f8,u8,i8,i8,f8[:,::1])")
def fading_sources(
    table: Float64,
    masks: UInt64,
    vertices: Float32,
    active: Int32,
    kind: int,
    repels: bool,
    x: float,
    z: float,
    groups: np.uint64,
    seed: int,
    agent: int,
    found: Float64,
) -> tuple[float, float, float]:
    """Return velocity and influence while the nearest source fades: the rest of its share goes to the next nearest.

    This avoids jumps; at most FADING sources are used. `found` (FADING, 4) is scratch.
    """
    wish_x, wish_z, influence, left = 0.0, 0.0, 0.0, 1.0
    for n in range(find_nearest(table, masks, vertices, active, kind, x, z, groups, found)):
        if left < 1e-3:
            break
        d, row, to_x, to_z = found[n, NEAR_DISTANCE], int(found[n, NEAR_ROW]), found[n, NEAR_X], found[n, NEAR_Z]
        share = left * table[row, LEVEL]
        fx, fz, asked = source_velocity(table, row, repels, d, to_x, to_z, seed, agent)
        wish_x += share * fx
        wish_z += share * fz
        influence = max(influence, table[row, LEVEL] * asked)
        left -= share
    return wish_x, wish_z, influence


@kernel("void(f8[:,::1],u8[::1],f4[:,:,::1],i8,f4[:,::1],u8[::1],f8[:,::1],f8[:,::1],i8,i8)")
def update_nearest(
    table: Float64,
    masks: UInt64,
    vertices: Float32,
    row: int,
    position: Float32,
    groups: UInt64,
    sums: Float64,
    near: Float64,
    begin: int,
    end: int,
) -> None:
    """Update near (A, 4) of the agents begin..end-1 with one source where it is the nearest so far."""
    x, z = table[row, X], table[row, Z]
    point = table[row, CORNERS] == 1.0 and table[row, RADIUS] == 0.0
    mask = masks[row]
    for i in range(begin, end):
        if sums[i, ADDRESSED_LEVEL] <= 0.0 or not addresses(mask, groups[i]):
            continue
        if not point:
            d, ux, uz = signed_distance(table, vertices, row, float(position[i, 0]), float(position[i, 1]))
        else:
            ux, uz = x - position[i, 0], z - position[i, 1]
            square, nearest = ux * ux + uz * uz, near[i, NEAR_DISTANCE]
            if square > nearest * nearest * SQUARE_ROUNDING:
                continue
            d = math.sqrt(square)
        if d < near[i, NEAR_DISTANCE]:
            scale = 1.0
            if point:
                scale = 1.0 / d if d > 1e-6 else 0.0
            near[i, NEAR_DISTANCE], near[i, NEAR_ROW] = d, row
            near[i, NEAR_X], near[i, NEAR_Z] = ux * scale, uz * scale


@kernel("void(f8[:,::1],u8[::1],f4[:,:,::1],i4[::1],i8,b1,f4[:,::1],u8[::1],f8[::1],f8[:,::1],f8[:,::1],i8,i8)")
def nearest_sources(
    table: Float64,
    masks: UInt64,
    vertices: Float32,
    active: Int32,
    kind: int,
    repels: bool,
    position: Float32,
    groups: UInt64,
    numbers: Float64,
    sums: Float64,
    near: Float64,
    begin: int,
    end: int,
) -> None:
    """Add the velocity of the agents begin..end-1 from the nearest source of a kind only (T106); near (A, 4) is
    scratch."""
    seed, switched = int(numbers[SEED]), numbers[SWITCHED] > 0.0
    found = np.empty((FADING, NEAR_COLUMNS))
    for i in range(begin, end):
        near[i, NEAR_DISTANCE], near[i, NEAR_ROW] = 1e30, -1.0
    for k in range(ACTIVE_START + active[kind], ACTIVE_START + active[kind + 1]):
        update_nearest(table, masks, vertices, active[k], position, groups, sums, near, begin, end)
    for i in range(begin, end):
        row = int(near[i, NEAR_ROW])
        if row < 0:
            continue
        if table[row, LEVEL] < 1.0:
            x, z = float(position[i, 0]), float(position[i, 1])
            fx, fz, asked = fading_sources(
                table, masks, vertices, active, kind, repels, x, z, groups[i], seed, i, found
            )
        else:
            d, to_x, to_z = near[i, NEAR_DISTANCE], near[i, NEAR_X], near[i, NEAR_Z]
            fx, fz, asked = source_velocity(table, row, repels, d, to_x, to_z, seed, i)
        add_velocity(sums, i, fx, fz, asked, switched)
