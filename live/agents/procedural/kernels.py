"""What the elements wish of every agent, in one pass over agents and acting elements (T083, T105-T110).

Behaviours are blended (a weighted sum, at most the top speed) or switched: those that come first in Reynolds' order of
urgency take what they want of the speed, the others share what is left ("prioritized acceleration allocation").
"""

import math

import numpy as np
import numpy.typing as npt

from live.agents.behaviours.kernels import (
    LOOK,
    arrive,
    evade,
    flow_grid,
    flow_radial,
    flow_vortex,
    follow_behind,
    follow_beside,
    follow_path,
    make_way,
    pursue,
    unit,
    wander,
)
from live.agents.procedural.crossing.kernels import GOAL_X, GOAL_Z, OWNER
from live.agents.procedural.fair.kernels import fair_attraction
from live.agents.procedural.kinds import (
    ATTRACTOR,
    CROSSING,
    EVADE,
    FLOCK,
    FLOW,
    FOLLOW,
    KIND_COUNT,
    PATH,
    PURSUE,
    RADIAL,
    REPULSOR,
    SPREADER,
    UNIFORM,
    VOICE,
    VORTEX,
    WANDER,
)
from live.agents.procedural.sources.kernels import ROWS, nearest_source, seen_from
from live.agents.procedural.spreading.kernels import spread
from live.agents.procedural.table.kernels import (
    ALIGNMENT,
    CLOSED,
    COHESION,
    CORNERS,
    DECAY,
    FLOW_KIND,
    LEVEL,
    RADIUS,
    SEPARATION,
    SERIAL,
    SLOT,
    STRENGTH,
    TARGET,
    TARGET_GROUP,
    WEDGE,
    X,
    Z,
    addresses,
)
from live.agents.wants import ALIGNMENT as WANTS_ALIGNMENT
from live.agents.wants import COHESION as WANTS_COHESION
from live.agents.wants import FIRM, PRESENCE, SPEED, VX, VZ
from live.agents.wants import SEPARATION as WANTS_SEPARATION
from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
UInt64 = npt.NDArray[np.uint64]

# numbers of a call
TIME, SEED, HALF_WIDTH, HALF_DEPTH, SWITCHED, PLACE_COUNT = 0, 1, 2, 3, 4, 5
NUMBERS = 6
# columns of the scratch for each agent (A, 4)
SPREAD_X, SPREAD_Z, BEFORE, RANK = 0, 1, 2, 3
SCRATCH_COLUMNS = 4
HUNTERS = 64
"""So many dancers of a group are looked at for the nearest."""
SPREADING_WANDER = 0.12
"""Share of the top speed that wandering takes while dancers spread (T109)."""


@kernel("i8(f4[:,::1],u8[::1],i8,i8)")
def first_of(wants: Float32, groups: UInt64, target: int, target_group: int) -> int:
    """The dancer who is meant: the target herself, or the first one present of a group; -1: nobody."""
    if target >= 0:
        return target if target < groups.shape[0] and wants[target, PRESENCE] > 0.0 else -1
    bit = np.uint64(1) << np.uint64(target_group)
    for i in range(groups.shape[0]):
        if wants[i, PRESENCE] > 0.0 and (groups[i] & bit) != np.uint64(0):
            return i
    return -1


@kernel("i8(f4[:,::1],f4[:,::1],u8[::1],i8,i8,i8)")
def nearest_of(position: Float32, wants: Float32, groups: UInt64, target: int, target_group: int, agent: int) -> int:
    """The dancer who is meant: the target herself, or the nearest one of a group; -1: nobody, never oneself."""
    if target >= 0:
        meant = target < groups.shape[0] and target != agent and wants[target, PRESENCE] > 0.0
        return target if meant else -1
    bit = np.uint64(1) << np.uint64(target_group)
    best, nearest, seen = -1, 1e30, 0
    for i in range(groups.shape[0]):
        if i == agent or wants[i, PRESENCE] <= 0.0 or (groups[i] & bit) == np.uint64(0):
            continue
        d2 = (position[i, 0] - position[agent, 0]) ** 2 + (position[i, 1] - position[agent, 1]) ** 2
        if d2 < nearest:
            best, nearest = i, d2
        seen += 1
        if seen == HUNTERS:
            break
    return best


@kernel("i8(f8[:,::1],u8[::1],i4[::1],i8,u8)")
def newest(table: Float64, masks: UInt64, active: Int32, kind: int, groups: np.uint64) -> int:
    """The newest acting element of a kind that addresses these groups; -1: none."""
    for k in range(ROWS + active[kind + 1] - 1, ROWS + active[kind] - 1, -1):
        if addresses(masks[active[k]], groups):
            return int(active[k])
    return -1


@kernel("UniTuple(f8,3)(f8[:,::1],u8[::1],f4[:,:,::1],i4[::1],f4[:,:,:,::1],f8,f8,u8,f8[::1])")
def flow_of(
    table: Float64,
    masks: UInt64,
    vertices: Float32,
    active: Int32,
    grids: Float32,
    x: float,
    z: float,
    groups: np.uint64,
    numbers: Float64,
) -> tuple[float, float, float]:
    """Sum of the flows at a place, and their influence. A flow with a radius acts only within it, softly at its edge."""
    wish_x, wish_z, influence = 0.0, 0.0, 0.0
    for k in range(ROWS + active[FLOW], ROWS + active[FLOW + 1]):
        row = active[k]
        if not addresses(masks[row], groups):
            continue
        ax, az, kind = table[row, X], table[row, Z], int(table[row, FLOW_KIND])
        if kind == UNIFORM:
            fx, fz = unit(vertices[row, 1, 0] - ax, vertices[row, 1, 1] - az)
        elif kind == RADIAL:
            fx, fz = flow_radial(x, z, ax, az, table[row, DECAY])
        elif kind == VORTEX:
            fx, fz = flow_vortex(x, z, ax, az, table[row, DECAY])
        else:
            fx, fz = flow_grid(grids, int(table[row, SLOT]), x, z, numbers[HALF_WIDTH], numbers[HALF_DEPTH])
        level = table[row, LEVEL]
        if table[row, RADIUS] > 0.0:
            d, _, _ = seen_from(table, vertices, row, x, z)
            level *= min(max(0.5 - d, 0.0), 1.0)
        wish_x += level * table[row, STRENGTH] * fx
        wish_z += level * table[row, STRENGTH] * fz
        influence = max(influence, level)
    return wish_x, wish_z, influence


@kernel("UniTuple(f8,3)(f8[:,::1],i8,f4[:,::1],f4[:,::1],f4[:,::1],u8[::1],f8[:,::1],i8)")
def follow_of(
    table: Float64,
    row: int,
    position: Float32,
    velocity: Float32,
    wants: Float32,
    groups: UInt64,
    scratch: Float64,
    i: int,
) -> tuple[float, float, float]:
    """Wish of one who follows a leader, behind or in a wedge, not in her way; and whether it is asked of her."""
    leader = first_of(wants, groups, int(table[row, TARGET]), int(table[row, TARGET_GROUP]))
    if leader < 0 or leader == i:
        return 0.0, 0.0, 0.0
    x, z = float(position[i, 0]), float(position[i, 1])
    before = int(scratch[i, BEFORE])
    gap = max(table[row, RADIUS], 0.9)
    way_x, way_z = make_way(x, z, position[leader, 0], position[leader, 1], velocity[leader, 0], velocity[leader, 1])
    if table[row, WEDGE] > 0.0:
        # towards the audience while the leader stands: a heading of rest has no other sense
        hx, hz = unit(float(velocity[leader, 0]), velocity[leader, 1] + 0.05)
        side = 1.0 if int(scratch[i, RANK]) % 2 == 0 else -1.0
        fx, fz = follow_beside(x, z, position[before, 0], position[before, 1], hx, hz, side, gap)
    else:
        fx, fz = follow_behind(
            x, z, position[before, 0], position[before, 1], velocity[before, 0], velocity[before, 1], gap
        )
    strength = table[row, STRENGTH]
    return strength * fx + way_x, strength * fz + way_z, 1.0


@kernel("void(f8[:,::1],u8[::1],i4[::1],f4[:,::1],u8[::1],f8[:,::1])")
def line_up(table: Float64, masks: UInt64, active: Int32, wants: Float32, groups: UInt64, scratch: Float64) -> None:
    """Who goes before whom: followers line up behind their leader in the order of their numbers."""
    for k in range(ROWS + active[FOLLOW], ROWS + active[FOLLOW + 1]):
        row = active[k]
        leader = first_of(wants, groups, int(table[row, TARGET]), int(table[row, TARGET_GROUP]))
        if leader < 0:
            continue
        last, last_but_one, rank = leader, leader, 0
        for i in range(groups.shape[0]):
            if i == leader or wants[i, PRESENCE] <= 0.0 or not addresses(masks[row], groups[i]):
                continue
            scratch[i, RANK] = rank
            if table[row, WEDGE] > 0.0:
                scratch[i, BEFORE] = last_but_one
                last_but_one, last = last, i
            else:
                scratch[i, BEFORE] = last
                last = i
            rank += 1


@kernel(
    "void(f8[:,::1],u8[::1],i4[::1],f4[:,::1],f4[:,::1],u8[::1],f8[::1],"
    "f4[:,:,::1],f4[:,:,::1],i4[::1],i4[:,::1],f8[:,::1])"
)
def spread_groups(
    table: Float64,
    masks: UInt64,
    active: Int32,
    position: Float32,
    wants: Float32,
    groups: UInt64,
    area: Float64,
    mesh: Float32,
    cosines: Float32,
    start: Int32,
    order: Int32,
    scratch: Float64,
) -> None:
    """Spread each spreader's dancers evenly among themselves; each belongs to the newest spreader that addresses her."""
    for k in range(ROWS + active[SPREADER], ROWS + active[SPREADER + 1]):
        row = active[k]
        members = 0
        for i in range(groups.shape[0]):
            if wants[i, PRESENCE] > 0.0 and newest(table, masks, active, SPREADER, groups[i]) == row:
                order[0, members] = i
                members += 1
        if members:
            spread(position, order[0], members, area, mesh, cosines, start, order[1], scratch)


@kernel("UniTuple(f8,3)(f8[:,::1],u8[::1],i4[::1],b1,f4[:,::1],f4[:,::1],f4[:,::1],u8[::1],i8)")
def hunt(
    table: Float64,
    masks: UInt64,
    active: Int32,
    flees: bool,
    position: Float32,
    velocity: Float32,
    wants: Float32,
    groups: UInt64,
    i: int,
) -> tuple[float, float, float]:
    """Wish of one who pursues (the newest quarry she was given) or evades (all hunters together), and influence."""
    wish_x, wish_z, influence = 0.0, 0.0, 0.0
    kind = EVADE if flees else PURSUE
    x, z, speed = float(position[i, 0]), float(position[i, 1]), float(wants[i, SPEED])
    for k in range(ROWS + active[kind + 1] - 1, ROWS + active[kind] - 1, -1):
        row = active[k]
        if not addresses(masks[row], groups[i]):
            continue
        j = nearest_of(position, wants, groups, int(table[row, TARGET]), int(table[row, TARGET_GROUP]), i)
        if j < 0:
            continue
        jx, jz, level = float(position[j, 0]), float(position[j, 1]), table[row, LEVEL]
        if flees:
            fx, fz = evade(x, z, jx, jz, velocity[j, 0], velocity[j, 1], speed)
            d = math.sqrt((jx - x) ** 2 + (jz - z) ** 2)
            level *= math.exp(-d / table[row, DECAY])
        else:
            fx, fz = pursue(x, z, jx, jz, velocity[j, 0], velocity[j, 1], speed)
        wish_x += level * table[row, STRENGTH] * fx
        wish_z += level * table[row, STRENGTH] * fz
        influence = max(influence, level)
        if not flees:
            break
    return wish_x, wish_z, influence


@kernel("UniTuple(f8,3)(f8,f8,f8,f8,f8,b1)")
def take(total_x: float, total_z: float, left: float, x: float, z: float, switched: bool) -> tuple[float, float, float]:
    """Add a wish to the sum: as it is (blended), or no more of it than is left of the speed (switched)."""
    if not switched:
        return total_x + x, total_z + z, left
    size = math.sqrt(x * x + z * z)
    if size > left:
        x, z, size = x * left / size, z * left / size, left
    return total_x + x, total_z + z, left - size


@kernel("UniTuple(f8,3)(f8[:,::1],i8,f8[:,::1],f4[:,::1],i8)")
def cross_of(table: Float64, row: int, memory: Float64, position: Float32, i: int) -> tuple[float, float, float]:
    """Wish of one who crosses over: to her place on the other side, where she stays."""
    if memory[i, OWNER] != table[row, SERIAL]:
        return 0.0, 0.0, 0.0
    fx, fz = arrive(position[i, 0], position[i, 1], memory[i, GOAL_X], memory[i, GOAL_Z], 1.0)
    strength = max(table[row, STRENGTH], 0.0)
    return strength * fx, strength * fz, 1.0


@kernel("UniTuple(f8,3)(f8[:,::1],u8[::1],f4[:,:,::1],i4[::1],f4[:,::1],f4[:,::1],f4[:,::1],u8,i8)")
def path_of(
    table: Float64,
    masks: UInt64,
    vertices: Float32,
    active: Int32,
    position: Float32,
    velocity: Float32,
    wants: Float32,
    groups: np.uint64,
    i: int,
) -> tuple[float, float, float]:
    """Wish of one who follows the newest path that she was given, and its influence."""
    row = newest(table, masks, active, PATH, groups)
    if row < 0:
        return 0.0, 0.0, 0.0
    fx, fz = follow_path(
        vertices,
        row,
        int(table[row, CORNERS]),
        table[row, CLOSED] > 0.0,
        max(table[row, RADIUS], 0.3),
        position[i, 0],
        position[i, 1],
        velocity[i, 0],
        velocity[i, 1],
        wants[i, SPEED],
    )
    size = table[row, LEVEL] * table[row, STRENGTH]
    return size * fx, size * fz, table[row, LEVEL]


@kernel("UniTuple(f8,3)(f8[:,::1],u8[::1],i4[::1],f4[:,::1],f4[:,::1],u8,f8[:,::1],f8[::1],i8)")
def drift_of(
    table: Float64,
    masks: UInt64,
    active: Int32,
    position: Float32,
    velocity: Float32,
    groups: np.uint64,
    scratch: Float64,
    numbers: Float64,
    i: int,
) -> tuple[float, float, float]:
    """Wish of those who go on by themselves: wandering, in a flock, or (a little) while they spread; and influence."""
    size, influence = 0.0, 0.0
    for kind in (WANDER, FLOCK, SPREADER):
        row = newest(table, masks, active, kind, groups)
        if row >= 0:
            level = table[row, LEVEL]
            size = max(size, level * table[row, STRENGTH] * (SPREADING_WANDER if kind == SPREADER else 1.0))
            influence = max(influence, level)
    if size <= 0.0:
        return 0.0, 0.0, influence
    fx, fz = wander(
        position[i, 0],
        position[i, 1],
        velocity[i, 0],
        velocity[i, 1],
        numbers[HALF_WIDTH],
        numbers[HALF_DEPTH],
        int(numbers[SEED]),
        i,
        numbers[TIME],
    )
    return size * fx, size * fz, influence


@kernel("f8(f8[:,::1],u8[::1],i4[::1],f4[:,::1],u8,i8)")
def company(table: Float64, masks: UInt64, active: Int32, wants: Float32, groups: np.uint64, i: int) -> float:
    """Write what the acting elements ask of an agent towards her neighbours; the largest level, 0: nobody means her."""
    most = 0.0
    for k in range(ROWS, ROWS + active[KIND_COUNT]):
        row = active[k]
        if addresses(masks[row], groups):
            level = table[row, LEVEL]
            most = max(most, level)
            wants[i, WANTS_SEPARATION] = max(wants[i, WANTS_SEPARATION], level * table[row, SEPARATION])
            wants[i, WANTS_ALIGNMENT] = max(wants[i, WANTS_ALIGNMENT], level * table[row, ALIGNMENT])
            wants[i, WANTS_COHESION] = max(wants[i, WANTS_COHESION], level * table[row, COHESION])
    return most


@kernel(
    "void(f4[:,::1],f4[:,::1],f4[:,::1],u8[::1],f8[:,::1],u8[::1],f4[:,:,::1],i4[::1],f4[:,:,:,::1],"
    "f8[:,::1],u8[::1],f8[:,::1],f8[:,::1],f8[::1],f4[::1])"
)
def wish_of_all(
    position: Float32,
    velocity: Float32,
    wants: Float32,
    groups: UInt64,
    table: Float64,
    masks: UInt64,
    vertices: Float32,
    active: Int32,
    grids: Float32,
    places: Float64,
    audience: UInt64,
    memory: Float64,
    scratch: Float64,
    numbers: Float64,
    influence: Float32,
) -> None:
    """Blend the wishes of all acting elements into `wants` (A, 8), and write how far they have taken each agent.

    position, velocity (A, 2); groups (A,); table, masks, vertices, active, grids, places, audience: the elements, as
    ElementField holds them; memory (A, 3): goals of crossings; scratch (A, 4): spreading and lining up, already done;
    numbers (6,); influence (A,), 0 to 1: 0 leaves the planned velocity as it is, 1 puts the elements' in its place.
    """
    seed, switched = int(numbers[SEED]), numbers[SWITCHED] > 0.0
    for i in range(position.shape[0]):
        influence[i] = 0.0
        g = groups[i]
        if wants[i, PRESENCE] <= 0.0 or company(table, masks, active, wants, g, i) <= 0.0:
            continue
        x, z = float(position[i, 0]), float(position[i, 1])
        sx, sz, left, most = 0.0, 0.0, 1.0, 0.0
        if active[REPULSOR] < active[REPULSOR + 1]:
            fx, fz, asked = nearest_source(table, masks, vertices, active, REPULSOR, True, x, z, g, seed, i)
            sx, sz, left = take(sx, sz, left, fx, fz, switched)
            most = max(most, asked)
        if active[EVADE] < active[EVADE + 1]:
            fx, fz, asked = hunt(table, masks, active, True, position, velocity, wants, groups, i)
            sx, sz, left = take(sx, sz, left, fx, fz, switched)
            most = max(most, asked)
        if active[CROSSING] < active[CROSSING + 1]:
            row = newest(table, masks, active, CROSSING, g)
            if row >= 0:
                fx, fz, asked = cross_of(table, row, memory, position, i)
                level = table[row, LEVEL]
                sx, sz, left = take(sx, sz, left, level * fx, level * fz, switched)
                most = max(most, level * asked)
        if active[FOLLOW] < active[FOLLOW + 1]:
            row = newest(table, masks, active, FOLLOW, g)
            if row >= 0:
                fx, fz, asked = follow_of(table, row, position, velocity, wants, groups, scratch, i)
                level = table[row, LEVEL]
                sx, sz, left = take(sx, sz, left, level * fx, level * fz, switched)
                most = max(most, level * asked)
        if active[PURSUE] < active[PURSUE + 1]:
            fx, fz, asked = hunt(table, masks, active, False, position, velocity, wants, groups, i)
            sx, sz, left = take(sx, sz, left, fx, fz, switched)
            most = max(most, asked)
        if active[PATH] < active[PATH + 1]:
            fx, fz, asked = path_of(table, masks, vertices, active, position, velocity, wants, g, i)
            sx, sz, left = take(sx, sz, left, fx, fz, switched)
            most = max(most, asked)
        if active[ATTRACTOR] < active[ATTRACTOR + 1]:
            fx, fz, asked = nearest_source(table, masks, vertices, active, ATTRACTOR, False, x, z, g, seed, i)
            sx, sz, left = take(sx, sz, left, fx, fz, switched)
            most = max(most, asked)
        if active[VOICE] < active[VOICE + 1]:
            fx, fz, asked = fair_attraction(places, audience, int(numbers[PLACE_COUNT]), x, z, g)
            sx, sz, left = take(sx, sz, left, fx, fz, switched)
            most = max(most, asked)
        if active[FLOW] < active[FLOW + 1]:
            ahead_x, ahead_z = x + velocity[i, 0] * LOOK, z + velocity[i, 1] * LOOK
            fx, fz, asked = flow_of(table, masks, vertices, active, grids, ahead_x, ahead_z, g, numbers)
            sx, sz, left = take(sx, sz, left, fx, fz, switched)
            most = max(most, asked)
        if active[SPREADER] < active[SPREADER + 1]:
            row = newest(table, masks, active, SPREADER, g)
            if row >= 0 and wants[i, SPEED] > 0.0:
                size = table[row, LEVEL] * max(table[row, STRENGTH], 0.0)
                fx, fz = scratch[i, SPREAD_X] / wants[i, SPEED], scratch[i, SPREAD_Z] / wants[i, SPEED]
                size /= max(math.sqrt(fx * fx + fz * fz), 1.0)
                sx, sz, left = take(sx, sz, left, size * fx, size * fz, switched)
        if active[WANDER] < active[FLOCK + 1] or active[SPREADER] < active[SPREADER + 1]:
            fx, fz, asked = drift_of(table, masks, active, position, velocity, g, scratch, numbers, i)
            sx, sz, left = take(sx, sz, left, fx, fz, switched)
            most = max(most, asked)
        size = max(math.sqrt(sx * sx + sz * sz), 1.0)
        scale, keep = wants[i, SPEED] / size, 1.0 - most
        wants[i, VX] = keep * wants[i, VX] + scale * sx
        wants[i, VZ] = keep * wants[i, VZ] + scale * sz
        wants[i, FIRM] *= keep
        influence[i] = most
