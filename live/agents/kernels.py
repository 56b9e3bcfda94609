"""Steering kernels: one pass over all agents and their neighbours per tick (T080-T083, T105-T109).

Choreography says what an agent wants (elements), steering makes it safe. Every agent reads the old state and writes
the new one, so the order of the agents does not matter. Formulas follow Schulz 2011, chapter 4, and Reynolds' words.
"""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.base.kernels import ease

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

NEIGHBOUR_RANGE = 2.5
"""Metres within which neighbours matter; the size of the cells in which they are looked up."""

# columns of the parameter vector: the fields of agents.model.Steering in their order
_HALF_WIDTH, _HALF_DEPTH, _ACCELERATION, _ATTRACT_DECAY, _REPEL_DECAY = 0, 1, 2, 3, 4
_SEPARATION, _NEAR, _FAR, _HORIZON, _EDGE, _CELL, _WANDER, _LEASH = 5, 6, 7, 8, 9, 10, 11, 12


@kernel("f8(i8,i8,i8)")
def hash_unit(seed: int, agent: int, turn: int) -> float:
    """A number in [0, 1) that depends on its three arguments only (mixing steps of murmur3): seeded chance."""
    h = (int(seed) * 0x9E3779B1 ^ int(agent) * 0x85EBCA77 ^ int(turn) * 0xC2B2AE3D) & 0xFFFFFFFF
    h = ((h ^ (h >> 16)) * 0x85EBCA6B) & 0xFFFFFFFF
    h = ((h ^ (h >> 13)) * 0xC2B2AE35) & 0xFFFFFFFF
    h = h ^ (h >> 16)
    return h / 4294967296.0


@kernel("i8(f8,f8,f8,f8,f8,i8,i8)")
def _cell_of(x: float, z: float, half_width: float, half_depth: float, size: float, columns: int, rows: int) -> int:
    """Index of the cell that holds (x, z); places off the stage belong to the nearest cell."""
    column = min(max(math.floor((x + half_width) / size), 0), columns - 1)
    row = min(max(math.floor((z + half_depth) / size), 0), rows - 1)
    return row * columns + column


@kernel("i8(f8,f8)")
def cell_count(extent: float, size: float) -> int:
    """How many cells of about `size` [m] cover `extent` [m]: at least one."""
    return max(1, math.ceil(extent / size - 1e-9))


@kernel("void(f4[:,::1], f8, f8, f8, i4[::1], i4[::1])")
def sort_into_cells(
    position: Float32, half_width: float, half_depth: float, size: float, cell_start: Int32, order: Int32
) -> None:
    """Counting sort: agents of cell c are order[cell_start[c]:cell_start[c + 1]], in the order of their numbers."""
    columns, rows = cell_count(2.0 * half_width, size), cell_count(2.0 * half_depth, size)
    cells = columns * rows
    for c in range(cells + 1):
        cell_start[c] = 0
    for i in range(position.shape[0]):
        cell_start[_cell_of(position[i, 0], position[i, 1], half_width, half_depth, size, columns, rows) + 1] += 1
    for c in range(cells):
        cell_start[c + 1] += cell_start[c]
    for i in range(position.shape[0] - 1, -1, -1):
        c = _cell_of(position[i, 0], position[i, 1], half_width, half_depth, size, columns, rows)
        # fill each cell from its end; the starts move back to where they were after all agents are placed
        cell_start[c + 1] -= 1
        order[cell_start[c + 1]] = i
    for c in range(cells):
        cell_start[c] = cell_start[c + 1]
    cell_start[cells] = position.shape[0]


@kernel("UniTuple(f8,2)(f8,f8,i4[::1],f4[:,::1],f4[::1],i8,f8[::1],i8,i8)")
def steer_sources(
    x: float,
    z: float,
    kind: Int32,
    source: Float32,
    strength: Float32,
    count: int,
    params: Float64,
    seed: int,
    agent: int,
) -> tuple[float, float]:
    """Wish, as a share of the top speed, towards the nearest attractor and away from the nearest repulsor.

    T105: repulsion f(d) = exp(-d / decay), attraction 1 - f(d). T106: only the nearest source of each kind acts,
    since a mix would pull everybody to the centre of mass.
    """
    wish_x, wish_z = 0.0, 0.0
    for wanted in range(2):
        best, nearest = -1, 1e30
        for e in range(count):
            if kind[e] == wanted and strength[e] > 0.0:
                d2 = (source[e, 0] - x) ** 2 + (source[e, 1] - z) ** 2
                if d2 < nearest:
                    best, nearest = e, d2
        if best < 0:
            continue
        d = math.sqrt(nearest)
        if d > 1e-6:
            ux, uz = (source[best, 0] - x) / d, (source[best, 1] - z) / d
        else:  # on the spot itself every direction is as good: let chance, seeded, choose
            angle = 2.0 * math.pi * hash_unit(seed, agent, 77)
            ux, uz = math.sin(angle), math.cos(angle)
        if wanted == 0:
            level = strength[best] * (1.0 - math.exp(-d / params[_ATTRACT_DECAY]))
        else:
            level = -strength[best] * math.exp(-d / params[_REPEL_DECAY])
        wish_x += level * ux
        wish_z += level * uz
    return wish_x, wish_z


@kernel("UniTuple(f8,2)(f8,f8,i4[::1],i8,f8[::1],i8,i8,i8)")
def steer_spread(
    x: float, z: float, population: Int32, agents: int, params: Float64, seed: int, agent: int, turn: int
) -> tuple[float, float]:
    """Wish while spreading (T109), as a share of the top speed: out of an over-populated cell, to the nearest free one.

    `population` (cells,) counts the agents of each cell. The agents that leave first are drawn by seeded chance, so
    that a crowd does not empty its cell all at once.
    """
    columns = cell_count(2.0 * params[_HALF_WIDTH], params[_CELL])
    rows = cell_count(2.0 * params[_HALF_DEPTH], params[_CELL])
    size_x, size_z = 2.0 * params[_HALF_WIDTH] / columns, 2.0 * params[_HALF_DEPTH] / rows
    mean = agents / (columns * rows)
    angle = 2.0 * math.pi * hash_unit(seed, agent, turn)
    wish_x, wish_z = params[_WANDER] * math.sin(angle), params[_WANDER] * math.cos(angle)
    own_column = min(max(math.floor((x + params[_HALF_WIDTH]) / size_x), 0), columns - 1)
    own_row = min(max(math.floor((z + params[_HALF_DEPTH]) / size_z), 0), rows - 1)
    own = own_row * columns + own_column
    if population[own] <= math.ceil(mean - 1e-9):
        return wish_x, wish_z
    best, nearest = -1, 1e30
    for c in range(columns * rows):
        if population[c] < math.floor(mean + 1e-9) or (population[c] == 0 and mean > 0.35):
            cx = -params[_HALF_WIDTH] + (c % columns + 0.5) * size_x
            cz = -params[_HALF_DEPTH] + (c // columns + 0.5) * size_z
            d2 = (cx - x) ** 2 + (cz - z) ** 2
            if d2 < nearest:
                best, nearest = c, d2
    if best >= 0 and hash_unit(seed + 1, agent, turn) < 1.0 - mean / population[own]:
        cx = -params[_HALF_WIDTH] + (best % columns + 0.5) * size_x
        cz = -params[_HALF_DEPTH] + (best // columns + 0.5) * size_z
        d = math.sqrt(nearest)
        return wish_x + (cx - x) / d, wish_z + (cz - z) / d
    dx = x - (-params[_HALF_WIDTH] + (own % columns + 0.5) * size_x)
    dz = z - (-params[_HALF_DEPTH] + (own // columns + 0.5) * size_z)
    d = math.sqrt(dx * dx + dz * dz) + 1e-6
    return wish_x + 0.5 * dx / d, wish_z + 0.5 * dz / d


@kernel("UniTuple(f8,2)(f8,f8,f8,f8,f8,f8)")
def steer_dodge(dx: float, dz: float, rvx: float, rvz: float, reach: float, horizon: float) -> tuple[float, float]:
    """Wish to leave the nearest approach to one neighbour, stronger the sooner it comes (T082).

    dx, dz: from the neighbour to the agent [m]; rvx, rvz: velocity relative to it [m/s]; reach: distance [m] that must
    be kept; horizon: seconds looked ahead.
    """
    closing = -(dx * rvx + dz * rvz)
    rv2 = rvx * rvx + rvz * rvz
    if closing <= 0.0 or rv2 < 1e-6 or closing > horizon * rv2:
        return 0.0, 0.0
    when = closing / rv2
    nx, nz = dx + rvx * when, dz + rvz * when
    gap = math.sqrt(nx * nx + nz * nz)
    if gap > reach:
        return 0.0, 0.0
    if gap < 0.05:  # head on: everybody keeps to the same side, which breaks the symmetry
        nx, nz = rvz, -rvx
        gap = math.sqrt(nx * nx + nz * nz)
    urgency = 1.0 - when / horizon
    return urgency * nx / gap, urgency * nz / gap


@kernel("UniTuple(f8,7)(i8,f4[:,::1],f4[:,::1],f4[::1],i4[::1],i4[::1],f8[::1],i8)")
def steer_neighbours(
    i: int,
    position: Float32,
    velocity: Float32,
    radius: Float32,
    cell_start: Int32,
    order: Int32,
    params: Float64,
    seed: int,
) -> tuple[float, float, float, float, float, float, float]:
    """Separation wish, avoidance wish (shares of the top speed), distance of the nearest neighbour, way to it.

    The way is a unit vector, (0, 0) if there is no neighbour. Separation and unaligned collision avoidance (predict
    the nearest approach, leave it) after Reynolds (T082).
    """
    half_width, half_depth = params[_HALF_WIDTH], params[_HALF_DEPTH]
    columns, rows = cell_count(2.0 * half_width, NEIGHBOUR_RANGE), cell_count(2.0 * half_depth, NEIGHBOUR_RANGE)
    home = _cell_of(position[i, 0], position[i, 1], half_width, half_depth, NEIGHBOUR_RANGE, columns, rows)
    x, z, vx, vz = position[i, 0], position[i, 1], velocity[i, 0], velocity[i, 1]
    push_x, push_z, dodge_x, dodge_z = 0.0, 0.0, 0.0, 0.0
    nearest, to_x, to_z = 1e30, 0.0, 0.0
    for row in range(max(home // columns - 1, 0), min(home // columns + 2, rows)):
        for column in range(max(home % columns - 1, 0), min(home % columns + 2, columns)):
            c = row * columns + column
            for k in range(cell_start[c], cell_start[c + 1]):
                j = order[k]
                if j == i:
                    continue
                dx, dz = x - position[j, 0], z - position[j, 1]
                d = math.sqrt(dx * dx + dz * dz)
                if d > NEIGHBOUR_RANGE:
                    continue
                if d < 1e-5:  # two agents in one place part in opposite directions, drawn for the pair
                    angle = 2.0 * math.pi * hash_unit(seed, min(i, j), max(i, j))
                    sign = 1.0 if i < j else -1.0
                    dx, dz, d = sign * 1e-5 * math.sin(angle), sign * 1e-5 * math.cos(angle), 1e-5
                if d < nearest:
                    nearest, to_x, to_z = d, -dx / d, -dz / d
                if d < params[_SEPARATION]:
                    force = (1.0 - d / params[_SEPARATION]) ** 2 * 2.5
                    push_x += force * dx / d
                    push_z += force * dz / d
                turn_x, turn_z = steer_dodge(
                    dx, dz, vx - velocity[j, 0], vz - velocity[j, 1], radius[i] + radius[j] + 0.15, params[_HORIZON]
                )
                dodge_x += turn_x
                dodge_z += turn_z
    return push_x, push_z, dodge_x, dodge_z, nearest, to_x, to_z


@kernel("void(f4[:,::1],f8[::1],i4[::1])")
def count_population(position: Float32, params: Float64, population: Int32) -> None:
    """How many agents stand in each of the spreaders' cells (T109), into population (cells,)."""
    columns = cell_count(2.0 * params[_HALF_WIDTH], params[_CELL])
    rows = cell_count(2.0 * params[_HALF_DEPTH], params[_CELL])
    size_x, size_z = 2.0 * params[_HALF_WIDTH] / columns, 2.0 * params[_HALF_DEPTH] / rows
    for c in range(columns * rows):
        population[c] = 0
    for i in range(position.shape[0]):
        column = min(max(math.floor((position[i, 0] + params[_HALF_WIDTH]) / size_x), 0), columns - 1)
        row = min(max(math.floor((position[i, 1] + params[_HALF_DEPTH]) / size_z), 0), rows - 1)
        population[row * columns + column] += 1


@kernel(
    "void(f4[:,::1],f4[:,::1],f4[:,::1],f4[:,::1],f4[::1],f4[::1],f4[:,::1],"
    "i4[::1],f4[:,::1],f4[::1],i8,f8[::1],i8,f8,f8,i4[::1],i4[::1],i4[::1])"
)
def advance_agents(
    out_position: Float32,
    out_velocity: Float32,
    position: Float32,
    velocity: Float32,
    radius: Float32,
    speed: Float32,
    dancer: Float32,
    kind: Int32,
    source: Float32,
    strength: Float32,
    count: int,
    params: Float64,
    seed: int,
    time: float,
    dt: float,
    cell_start: Int32,
    order: Int32,
    population: Int32,
) -> None:
    """Advance all agents by dt [s]: wishes → desired velocity → steering = desired - current (T081) → new state.

    position, velocity, out_* (A, 2); radius, speed (A,) [m, m/s]; dancer (A, 2): where each agent's dancer stands;
    kind, source, strength: the first `count` elements in force; params: Steering.vector(); cell_start, order,
    population: scratch for the neighbour cells and the spreaders' cells. The thesis' rule T108 (closer than d_s ignore
    all other behaviours) stops whole crowds, which then cannot even part; here, between `far` and `near`, only that
    share of the wishes is ignored which leads into the nearest neighbour, and under `near` the speed is limited.
    """
    sort_into_cells(position, params[_HALF_WIDTH], params[_HALF_DEPTH], NEIGHBOUR_RANGE, cell_start, order)
    spread = 0.0
    for e in range(count):
        if kind[e] == 2:
            spread = max(spread, strength[e])
    if spread > 0.0:
        count_population(position, params, population)
    turn = int(time)
    for i in range(position.shape[0]):
        x, z = position[i, 0], position[i, 1]
        wish_x, wish_z = steer_sources(x, z, kind, source, strength, count, params, seed, i)
        if spread > 0.0:
            sx, sz = steer_spread(x, z, population, position.shape[0], params, seed, i, turn)
            wish_x += spread * sx
            wish_z += spread * sz
        size = math.sqrt(wish_x * wish_x + wish_z * wish_z)
        if size > 1.0:
            wish_x, wish_z = wish_x / size, wish_z / size
        push_x, push_z, dodge_x, dodge_z, nearest, to_x, to_z = steer_neighbours(
            i, position, velocity, radius, cell_start, order, params, seed
        )
        wish_x, wish_z = wish_x + dodge_x, wish_z + dodge_z
        close = 1.0 - ease((nearest - params[_NEAR]) / (params[_FAR] - params[_NEAR]))
        into = close * max(wish_x * to_x + wish_z * to_z, 0.0)
        over_x = max(0.0, abs(x) - (params[_HALF_WIDTH] - params[_EDGE])) / params[_EDGE]
        over_z = max(0.0, abs(z) - (params[_HALF_DEPTH] - params[_EDGE])) / params[_EDGE]
        desired_x = wish_x - into * to_x + push_x - math.copysign(over_x, x)
        desired_z = wish_z - into * to_z + push_z - math.copysign(over_z, z)
        lag = math.sqrt((x - dancer[i, 0]) ** 2 + (z - dancer[i, 1]) ** 2)
        limit = speed[i] * min(max(2.0 - lag / params[_LEASH], 0.1), 1.0)
        if nearest < params[_NEAR]:
            limit *= 0.6
        size = math.sqrt(desired_x * desired_x + desired_z * desired_z)
        scale = limit * (1.0 if size < 1.0 else 1.0 / size)
        step_x, step_z = desired_x * scale - velocity[i, 0], desired_z * scale - velocity[i, 1]
        size = math.sqrt(step_x * step_x + step_z * step_z)
        most = params[_ACCELERATION] * dt
        if size > most:
            step_x, step_z = step_x * most / size, step_z * most / size
        vx, vz = velocity[i, 0] + step_x, velocity[i, 1] + step_z
        px, pz = x + vx * dt, z + vz * dt
        if abs(px) > params[_HALF_WIDTH]:
            px, vx = math.copysign(params[_HALF_WIDTH], px), 0.0
        if abs(pz) > params[_HALF_DEPTH]:
            pz, vz = math.copysign(params[_HALF_DEPTH], pz), 0.0
        out_position[i, 0], out_position[i, 1] = px, pz
        out_velocity[i, 0], out_velocity[i, 1] = vx, vz


@kernel("void(f4[:,::1],f4[:,::1],i8,f8,f8,f8)")
def _move_within(position: Float32, anchor: Float32, i: int, dx: float, dz: float, most: float) -> None:
    """Move agent i by (dx, dz) [m], then back towards its anchor until it is at most `most` [m] away from it."""
    x, z = position[i, 0] + dx - anchor[i, 0], position[i, 1] + dz - anchor[i, 1]
    d = math.sqrt(x * x + z * z)
    scale = most / d if d > most else 1.0
    position[i, 0], position[i, 1] = anchor[i, 0] + x * scale, anchor[i, 1] + z * scale


@kernel("void(f4[:,::1],f4[:,::1],f8,f8,f8,f8,i8,i8,i4[::1],i4[::1])")
def part_positions(
    position: Float32,
    anchor: Float32,
    gap: float,
    most: float,
    half_width: float,
    half_depth: float,
    rounds: int,
    seed: int,
    cell_start: Int32,
    order: Int32,
) -> None:
    """Move `position` (A, 2) apart in place until neighbours are `gap` [m] away, as far as `most` [m] allows.

    Nobody is moved farther than `most` from its `anchor` (A, 2). In each of the `rounds` the pairs are taken in the
    order of their numbers and share the way between them.
    """
    columns, rows = cell_count(2.0 * half_width, NEIGHBOUR_RANGE), cell_count(2.0 * half_depth, NEIGHBOUR_RANGE)
    for _ in range(rounds):
        sort_into_cells(position, half_width, half_depth, NEIGHBOUR_RANGE, cell_start, order)
        for i in range(position.shape[0]):
            home = _cell_of(position[i, 0], position[i, 1], half_width, half_depth, NEIGHBOUR_RANGE, columns, rows)
            for row in range(max(home // columns - 1, 0), min(home // columns + 2, rows)):
                for column in range(max(home % columns - 1, 0), min(home % columns + 2, columns)):
                    c = row * columns + column
                    for k in range(cell_start[c], cell_start[c + 1]):
                        j = order[k]
                        if j <= i:
                            continue
                        dx, dz = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
                        d = math.sqrt(dx * dx + dz * dz)
                        if d >= gap:
                            continue
                        if d < 1e-5:
                            angle = 2.0 * math.pi * hash_unit(seed, i, j)
                            dx, dz, d = math.sin(angle), math.cos(angle), 1.0
                            share = 0.5 * gap
                        else:
                            share = 0.5 * (gap - d)
                        _move_within(position, anchor, i, -dx / d * share, -dz / d * share, most)
                        _move_within(position, anchor, j, dx / d * share, dz / d * share, most)
