"""Contacts and bounds: bodies that approach slow down and never overlap (position based, Jacobi).

Stage edges, walls and obstacles limit velocities and positions (T107).
"""

import math

import numpy as np
import numpy.typing as npt

from live.agents.crowd.spatial_grid_kernels import MOBILITY, RADIUS, X, Z
from live.base.jit import inline_kernel, kernel

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

CAPACITY = 64
"""Largest number of walls, and of obstacles."""
AVOID_DISTANCE = 1.5
"""Distance [m] at which avoidance of an obstacle or wall begins."""
TOUCH_GAP = 0.1
SWERVE = 0.5
"""Sideways share of the approach speed towards a round obstacle; fades in between AHEAD and a gap of `CLOSE` [m]."""
EDGE_TIME = 0.25
"""Minimum time [s] to reach an edge, wall or obstacle; limits the speed towards it."""


@kernel("f8(f8,f8,f8,f8)")
def clamp_axis_velocity(v: float, at: float, half: float, most: float) -> float:
    """Clamp a velocity along one axis [m/s] at an edge `half` [m] from the middle; steer back if beyond it."""
    if at > half:
        return min(v, -min(most, (at - half) / EDGE_TIME))
    if at < -half:
        return max(v, min(most, (-half - at) / EDGE_TIME))
    return min(max(v, -(half + at) / EDGE_TIME), (half - at) / EDGE_TIME)


@kernel("void(f4[:,::1], f4[:,::1], f4[::1], i4[::1], i8, f4[::1])")
def clamp_to_stage(
    moved: Float32, sorted_: Float32, commands: Float32, slot_agent: Int32, n: int, params: Float32
) -> None:
    """Clamp the velocities in `moved` at the stage edges, except for passing agents. wants (8 A,): Wants.rows."""
    half_width, half_depth = float(params[0]), float(params[1])
    soon = np.float32(EDGE_TIME)
    if math.isinf(half_width) and math.isinf(half_depth):
        return
    for s in range(n):
        i = slot_agent[s]
        x, z = abs(sorted_[0, s]) + soon * abs(moved[0, s]), abs(sorted_[1, s]) + soon * abs(moved[1, s])
        if (x <= params[0] and z <= params[1]) or commands[8 * i + 7] >= np.float32(2.0):
            continue
        most = max(float(commands[8 * i + 2]), 0.1)
        moved[0, s] = clamp_axis_velocity(moved[0, s], sorted_[0, s], half_width, most)
        moved[1, s] = clamp_axis_velocity(moved[1, s], sorted_[1, s], half_depth, most)


@kernel("UniTuple(f8,2)(f8,f8,f4[:,::1],i8)")
def wall_offset(x: float, z: float, walls: Float32, w: int) -> tuple[float, float]:
    """Return the vector from the nearest point of wall w to (x, z) [m]."""
    ax, az = float(walls[w, 0]), float(walls[w, 1])
    ex, ez = float(walls[w, 2]) - ax, float(walls[w, 3]) - az
    length2 = ex * ex + ez * ez
    t = min(max(((x - ax) * ex + (z - az) * ez) / length2, 0.0), 1.0) if length2 > 1e-12 else 0.0
    return x - ax - t * ex, z - az - t * ez


@kernel("void(f4[:,::1], f4[:,::1], i8, f4[:,::1], i8, f4[:,::1], i8)")
def deflect_velocities(
    moved: Float32, sorted_: Float32, n: int, walls: Float32, wall_count: int, obstacles: Float32, obstacle_count: int
) -> None:
    """Deflect the velocities in `moved` around walls and obstacles (obstacle avoidance, T082).

    A head-on approach gives no side to slide to. So an agent swerves well before a round obstacle, to the side it
    already tends to, or else always to the same side. An agent that touches the obstacle is not deflected further,
    since its goal may be there. Agents slide along walls, and stop at a wall square to their way.
    """
    for s in range(n):
        x, z, radius = float(sorted_[0, s]), float(sorted_[1, s]), float(sorted_[4, s])
        vx, vz = float(moved[0, s]), float(moved[1, s])
        for w in range(wall_count + obstacle_count):
            ux, uz, reach = 0.0, 0.0, radius
            if w < wall_count:
                dx, dz = wall_offset(x, z, walls, w)
            else:
                o = w - wall_count
                dx, dz = x - obstacles[o, 0], z - obstacles[o, 1]
                ux, uz, reach = float(obstacles[o, 3]), float(obstacles[o, 4]), radius + obstacles[o, 2]
            d = math.sqrt(dx * dx + dz * dz)
            if d < 1e-9 or d > reach + AVOID_DISTANCE:
                continue
            nx, nz = dx / d, dz / d
            at, gap = (vx - ux) * nx + (vz - uz) * nz, d - reach
            inward = gap / EDGE_TIME + at
            if inward < 0.0:
                vx, vz = vx - inward * nx, vz - inward * nz
            if w >= wall_count and at < 0.0 and gap > TOUCH_GAP:
                along, least = vx * nz - vz * nx, -SWERVE * at * (1.0 - gap / AVOID_DISTANCE)
                if abs(along) < least:
                    more = math.copysign(least, along) - along
                    vx, vz = vx + more * nz, vz - more * nx
        moved[0, s], moved[1, s] = vx, vz


@kernel("UniTuple(f8,2)(f8,f8,f8,f8,f8,f4[:,::1],i8,f4[:,::1],i8)")
def project_outside(
    x: float,
    z: float,
    old_x: float,
    old_z: float,
    radius: float,
    walls: Float32,
    wall_count: int,
    obstacles: Float32,
    obstacle_count: int,
) -> tuple[float, float]:
    """Return the position moved out of walls and obstacles, to the side of the previous position."""
    for w in range(wall_count + obstacle_count):
        reach = radius
        if w < wall_count:
            dx, dz = wall_offset(x, z, walls, w)
            bx, bz = wall_offset(old_x, old_z, walls, w)
        else:
            o = w - wall_count
            dx, dz = x - obstacles[o, 0], z - obstacles[o, 1]
            bx, bz = dx, dz
            reach += obstacles[o, 2]
        d = math.sqrt(dx * dx + dz * dz)
        through = dx * bx + dz * bz < 0.0 and d < reach
        if d >= reach and not through:
            continue
        side = -1.0 if through else 1.0
        if d < 1e-6:
            dx, dz, d, side = bx, bz, math.sqrt(bx * bx + bz * bz), 1.0
            if d < 1e-6:
                dx, dz, d = 0.0, 1.0, 1.0
            x, z = x + dx / d * reach, z + dz / d * reach
        else:
            more = reach - side * d
            x, z = x + side * dx / d * more, z + side * dz / d * more
    return x, z


CONTACT_MARGIN = 0.3
"""Gap [m] below which two bodies are tracked as a contact pair."""
CONTACT_TIME = 0.15
"""Minimum time [s] to contact of two bodies; limits their closing speed."""
COMFORT_GAP = 0.03
"""Gap [m] that bodies keep when they meet."""
CREEP = 0.2
"""Rate [1/s] at which a lasting push narrows it."""
VELOCITY_ITERATIONS = 12
POSITION_ITERATIONS = 24
MIN_GAP = 0.001
"""Smallest gap kept between two bodies [m]."""
MIN_MOBILITY = 0.02
"""Mobility of a soloist; above 0, so that two soloists can separate."""


@inline_kernel
def mobility(sorted_: Float32, s: int) -> float:
    """Return the share of a correction that the agent in slot s takes."""
    return max(2.0 - float(sorted_[MOBILITY, s]), MIN_MOBILITY)


@inline_kernel
def append_contact_pairs(sorted_: Float32, i: int, touches: Int32, count: int, pairs: Int32, pair_count: int) -> int:
    """Append the contact pairs of agent i with later agents of `touches`; return the new number of pairs."""
    for m in range(count):
        k = touches[m]
        dx, dz = sorted_[X, i] - sorted_[X, k], sorted_[Z, i] - sorted_[Z, k]
        reach = sorted_[RADIUS, i] + sorted_[RADIUS, k] + np.float32(CONTACT_MARGIN)
        if k > i and dx * dx + dz * dz < reach * reach and 2 * pair_count + 2 <= pairs.shape[0]:
            pairs[2 * pair_count], pairs[2 * pair_count + 1] = i, k
            pair_count += 1
    return pair_count


SIDESTEP = 2.0
"""Acceleration to the right of two who stand in each other's way [m/s²]."""
HEAD_ON = 0.3
"""Speed at which each of them has to want to go towards the other [m/s]."""


@kernel("void(f4[:,::1], f4[:,::1], f4[::1], i4[::1], i4[::1], i8, f8)")
def step_aside(
    moved: Float32, sorted_: Float32, commands: Float32, slot_agent: Int32, pairs: Int32, pair_count: int, dt: float
) -> None:
    """Let two who want to go where the other is step aside, each to their right: so opposite streams form lanes.

    commands (8 A,): AgentCommand.rows.
    """
    for p in range(pair_count):
        i, j = pairs[2 * p], pairs[2 * p + 1]
        dx, dz = float(sorted_[X, j]) - sorted_[X, i], float(sorted_[Z, j]) - sorted_[Z, i]
        d = math.sqrt(dx * dx + dz * dz)
        if d < 1e-6:
            continue
        nx, nz = dx / d, dz / d
        own, other = 8 * slot_agent[i], 8 * slot_agent[j]
        gap = d - float(sorted_[RADIUS, i]) - float(sorted_[RADIUS, j])
        ahead = commands[own] * nx + commands[own + 1] * nz
        against = -(commands[other] * nx + commands[other + 1] * nz)
        head_on = min(min(ahead, against) - HEAD_ON, 1.0)
        if head_on <= 0.0:
            continue
        size = SIDESTEP * dt * head_on * (1.0 - max(commands[own + 6], commands[other + 6]))
        size *= min(max(1.0 - gap / CONTACT_MARGIN, 0.0), 1.0)
        mi, mj = min(mobility(sorted_, i), 1.0), min(mobility(sorted_, j), 1.0)
        moved[0, i] -= size * mi * nz
        moved[1, i] += size * mi * nx
        moved[0, j] += size * mj * nz
        moved[1, j] -= size * mj * nx


@inline_kernel
def _is_open(change: Float32, i: int, j: int, turn: int) -> bool:
    """Whether one of a pair was moved in the turn before, or is being moved in this one: else nothing is new for it.

    change[2, s] counts the corrections of the agent in slot s in this turn; after they are applied it is minus the
    number of turns done.
    """
    return bool(turn == 0 or change[2, i] > 0.0 or change[2, j] > 0.0 or change[2, i] == -turn or change[2, j] == -turn)


@inline_kernel
def _correct(change: Float32, s: int, x: float, z: float) -> None:
    """Add a correction of the agent in slot s to those of this turn."""
    if change[2, s] <= 0.0:
        change[0, s], change[1, s], change[2, s] = 0.0, 0.0, 0.0
    change[0, s] += x
    change[1, s] += z
    change[2, s] += 1.0


@inline_kernel
def _apply_corrections(moved: Float32, row: int, pairs: Int32, pair_count: int, change: Float32, turn: int) -> None:
    """Apply the corrections of this turn to rows `row` and `row` + 1 of `moved`, once for each agent of a pair."""
    for k in range(2 * pair_count):
        s = pairs[k]
        if change[2, s] > 0.0:
            scale = 1.0 if change[2, s] < 1.5 else 1.5 / change[2, s]
            moved[row, s] += change[0, s] * scale
            moved[row + 1, s] += change[1, s] * scale
            change[2, s] = -(turn + 1)


@kernel("void(f4[:,::1], f4[:,::1], i4[::1], i8, f4[:,::1], i8, f8)")
def limit_closing_speeds(
    moved: Float32, sorted_: Float32, pairs: Int32, pair_count: int, change: Float32, n: int, dt: float
) -> None:
    """Reduce closing velocities in `moved` until no pair approaches faster than the gap between them allows."""
    for s in range(n):
        change[2, s] = 0.0
    for turn in range(VELOCITY_ITERATIONS):
        worst = 0.0
        for p in range(pair_count):
            i, j = pairs[2 * p], pairs[2 * p + 1]
            if not _is_open(change, i, j, turn):
                continue
            dx, dz = float(sorted_[0, i]) - sorted_[0, j], float(sorted_[1, i]) - sorted_[1, j]
            d = math.sqrt(dx * dx + dz * dz)
            nx, nz = (dx / d, dz / d) if d > 1e-6 else (1.0, 0.0)
            gap = d - float(sorted_[4, i]) - float(sorted_[4, j])
            inward = max(gap - COMFORT_GAP, 0.0) / max(CONTACT_TIME, dt) + max(gap, 0.0) * CREEP
            inward += (float(moved[0, i]) - moved[0, j]) * nx + (float(moved[1, i]) - moved[1, j]) * nz
            if inward < 0.0:
                mi, mj = mobility(sorted_, i), mobility(sorted_, j)
                worst = min(worst, inward)
                share, other = -inward * mi / (mi + mj), inward * mj / (mi + mj)
                _correct(change, i, share * nx, share * nz)
                _correct(change, j, other * nx, other * nz)
        if worst > -1e-4:
            return
        _apply_corrections(moved, 0, pairs, pair_count, change, turn)


@kernel("void(f4[:,::1], f4[:,::1], i4[::1], i8, f4[:,::1], i8, f4[:,::1], i8, f4[:,::1], i8)")
def resolve_overlaps(
    moved: Float32,
    sorted_: Float32,
    pairs: Int32,
    pair_count: int,
    change: Float32,
    n: int,
    walls: Float32,
    wall_count: int,
    obstacles: Float32,
    obstacle_count: int,
) -> None:
    """Separate the new positions in `moved` (rows 2, 3) until no bodies, walls or obstacles overlap."""
    things = wall_count + obstacle_count
    for s in range(n):
        change[2, s] = 0.0
    for turn in range(POSITION_ITERATIONS):
        worst = 0.0
        for p in range(pair_count):
            i, j = pairs[2 * p], pairs[2 * p + 1]
            if things == 0 and not _is_open(change, i, j, turn):
                continue
            dx, dz = float(moved[2, i]) - moved[2, j], float(moved[3, i]) - moved[3, j]
            d = math.sqrt(dx * dx + dz * dz)
            over = float(sorted_[4, i]) + float(sorted_[4, j]) + MIN_GAP - d
            if over > 0.0:
                nx, nz = (dx / d, dz / d) if d > 1e-6 else (1.0, 0.0)
                worst = max(worst, over)
                mi, mj = mobility(sorted_, i), mobility(sorted_, j)
                share, other = over * mi / (mi + mj), -over * mj / (mi + mj)
                _correct(change, i, share * nx, share * nz)
                _correct(change, j, other * nx, other * nz)
        if worst < 1e-4 and (turn > 0 or things == 0):
            return
        _apply_corrections(moved, 2, pairs, pair_count, change, turn)
        for s in range(n if things > 0 else 0):
            moved[2, s], moved[3, s] = project_outside(
                moved[2, s], moved[3, s], sorted_[0, s], sorted_[1, s], sorted_[4, s], walls, wall_count, obstacles,
                obstacle_count,
            )  # fmt: skip
