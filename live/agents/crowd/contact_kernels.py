"""Contacts: bodies that come near slow down towards each other, and never overlap (position based, Jacobi).

Bounds: stage edges, walls and obstacles keep velocities and places in (T107).
"""

import math

import numpy as np
import numpy.typing as npt

from live.agents.crowd.spatial_grid_kernels import RADIUS, X, Z
from live.base.jit import kernel, part

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

CAPACITY = 64
"""How many walls, and how many obstacles, there may be at a time."""
AHEAD = 1.5
"""Metres before an obstacle or wall from which on it is seen."""
CLOSE = 0.1
SWERVE = 0.5
"""How much of her speed at it an agent takes to the side before she is as `CLOSE` [m] to something round."""
SOFT_LANDING = 0.25
"""Seconds: nobody goes at an edge, a wall or a body faster than she would reach it in this time."""


@kernel("f8(f8,f8,f8,f8)")
def _within(v: float, at: float, half: float, most: float) -> float:
    """Velocity along one axis [m/s] that does not lead over an edge `half` [m] from the middle, and back if beyond."""
    if at > half:
        return min(v, -min(most, (at - half) / SOFT_LANDING))
    if at < -half:
        return max(v, min(most, (-half - at) / SOFT_LANDING))
    return min(max(v, -(half + at) / SOFT_LANDING), (half - at) / SOFT_LANDING)


@kernel("void(f4[:,::1], f4[:,::1], f4[::1], i4[::1], i8, f4[::1])")
def keep_on_stage(moved: Float32, sorted_: Float32, wants: Float32, slot_agent: Int32, n: int, params: Float32) -> None:
    """Bend the velocities in `moved` at the stage edges, but for those who pass. wants (8 A,): Wants.rows."""
    half_width, half_depth = float(params[0]), float(params[1])
    soon = np.float32(SOFT_LANDING)
    if math.isinf(half_width) and math.isinf(half_depth):
        return
    for s in range(n):
        i = slot_agent[s]
        x, z = abs(sorted_[0, s]) + soon * abs(moved[0, s]), abs(sorted_[1, s]) + soon * abs(moved[1, s])
        if (x <= params[0] and z <= params[1]) or wants[8 * i + 7] >= np.float32(2.0):
            continue
        most = max(float(wants[8 * i + 2]), 0.1)
        moved[0, s] = _within(moved[0, s], sorted_[0, s], half_width, most)
        moved[1, s] = _within(moved[1, s], sorted_[1, s], half_depth, most)


@kernel("UniTuple(f8,2)(f8,f8,f4[:,::1],i8)")
def wall_way(x: float, z: float, walls: Float32, w: int) -> tuple[float, float]:
    """From the nearest point of wall w to (x, z) [m]."""
    ax, az = float(walls[w, 0]), float(walls[w, 1])
    ex, ez = float(walls[w, 2]) - ax, float(walls[w, 3]) - az
    length2 = ex * ex + ez * ez
    t = min(max(((x - ax) * ex + (z - az) * ez) / length2, 0.0), 1.0) if length2 > 1e-12 else 0.0
    return x - ax - t * ex, z - az - t * ez


@kernel("void(f4[:,::1], f4[:,::1], i8, f4[:,::1], i8, f4[:,::1], i8)")
def bend_at_surroundings(
    moved: Float32, sorted_: Float32, n: int, walls: Float32, wall_count: int, obstacles: Float32, obstacle_count: int
) -> None:
    """Bend the velocities in `moved` at walls and obstacles: round them, never into them (obstacle avoidance, T082).

    Head on there would be no side to slide to: well before a round obstacle she swerves a little, to the side she
    tends to or else to one and the same. Once she touches it she is left alone: what she wants may be there. Along a
    wall she slides, and is held where it lies square in her way.
    """
    for s in range(n):
        x, z, radius = float(sorted_[0, s]), float(sorted_[1, s]), float(sorted_[4, s])
        vx, vz = float(moved[0, s]), float(moved[1, s])
        for w in range(wall_count + obstacle_count):
            ux, uz, reach = 0.0, 0.0, radius
            if w < wall_count:
                dx, dz = wall_way(x, z, walls, w)
            else:
                o = w - wall_count
                dx, dz = x - obstacles[o, 0], z - obstacles[o, 1]
                ux, uz, reach = float(obstacles[o, 3]), float(obstacles[o, 4]), radius + obstacles[o, 2]
            d = math.sqrt(dx * dx + dz * dz)
            if d < 1e-9 or d > reach + AHEAD:
                continue
            nx, nz = dx / d, dz / d
            at, gap = (vx - ux) * nx + (vz - uz) * nz, d - reach
            inward = gap / SOFT_LANDING + at
            if inward < 0.0:
                vx, vz = vx - inward * nx, vz - inward * nz
            if w >= wall_count and at < 0.0 and gap > CLOSE:
                along, least = vx * nz - vz * nx, -SWERVE * at * (1.0 - gap / AHEAD)
                if abs(along) < least:
                    more = math.copysign(least, along) - along
                    vx, vz = vx + more * nz, vz - more * nx
        moved[0, s], moved[1, s] = vx, vz


@kernel("UniTuple(f8,2)(f8,f8,f8,f8,f8,f4[:,::1],i8,f4[:,::1],i8)")
def outside_surroundings(
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
    """The place moved out of walls and obstacles, to the side from which she came."""
    for w in range(wall_count + obstacle_count):
        reach = radius
        if w < wall_count:
            dx, dz = wall_way(x, z, walls, w)
            bx, bz = wall_way(old_x, old_z, walls, w)
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
"""Metres of gap from which on two bodies are watched for contact."""
LANDING = 0.15
"""Seconds: two bodies never near each other faster than they would touch in this time."""
ROUNDS = 12
PARTING_ROUNDS = 24
SPARE = 0.001
"""Metres kept between two bodies."""
LEAST_SHARE = 0.02
"""Mobility of a soloist: somebody has to give way where two of them meet."""


@part
def note_pairs(sorted_: Float32, i: int, touches: Int32, count: int, pairs: Int32, pair_count: int) -> int:
    """Write down with which later ones of `touches` agent i is near contact; returns the new number of pairs."""
    for m in range(count):
        k = touches[m]
        dx, dz = sorted_[X, i] - sorted_[X, k], sorted_[Z, i] - sorted_[Z, k]
        reach = sorted_[RADIUS, i] + sorted_[RADIUS, k] + np.float32(CONTACT_MARGIN)
        if k > i and dx * dx + dz * dz < reach * reach and 2 * pair_count + 2 <= pairs.shape[0]:
            pairs[2 * pair_count], pairs[2 * pair_count + 1] = i, k
            pair_count += 1
    return pair_count


@kernel("void(f4[:,::1], f4[:,::1], i4[::1], i8, f4[:,::1], i8, f8)")
def land_softly(
    moved: Float32, sorted_: Float32, pairs: Int32, pair_count: int, change: Float32, n: int, dt: float
) -> None:
    """Change the velocities in `moved` until no pair nears faster than LANDING allows."""
    for _ in range(ROUNDS):
        for s in range(n):
            change[0, s], change[1, s], change[2, s] = 0.0, 0.0, 0.0
        worst = 0.0
        for p in range(pair_count):
            i, j = pairs[2 * p], pairs[2 * p + 1]
            dx, dz = float(sorted_[0, i]) - sorted_[0, j], float(sorted_[1, i]) - sorted_[1, j]
            d = math.sqrt(dx * dx + dz * dz)
            nx, nz = (dx / d, dz / d) if d > 1e-6 else (1.0, 0.0)
            gap = d - float(sorted_[4, i]) - float(sorted_[4, j])
            inward = max(gap, 0.0) / max(LANDING, dt) + (float(moved[0, i]) - moved[0, j]) * nx
            inward += (float(moved[1, i]) - moved[1, j]) * nz
            if inward < 0.0:
                mi, mj = max(2.0 - sorted_[5, i], LEAST_SHARE), max(2.0 - sorted_[5, j], LEAST_SHARE)
                worst = min(worst, inward)
                share = -inward * mi / (mi + mj)
                change[0, i] += share * nx
                change[1, i] += share * nz
                change[2, i] += 1.0
                share = -inward * mj / (mi + mj)
                change[0, j] -= share * nx
                change[1, j] -= share * nz
                change[2, j] += 1.0
        if worst > -1e-4:
            return
        for s in range(n):
            if change[2, s] > 0.0:
                scale = 1.0 if change[2, s] < 1.5 else 1.5 / change[2, s]
                moved[0, s] += change[0, s] * scale
                moved[1, s] += change[1, s] * scale


@kernel("f8(f4[:,::1], f4[:,::1], i4[::1], i8, f4[:,::1])")
def _push_apart(moved: Float32, sorted_: Float32, pairs: Int32, pair_count: int, change: Float32) -> float:
    """Sum in `change` by how much each body has to move out of the others; returns the deepest overlap [m]."""
    worst = 0.0
    for p in range(pair_count):
        i, j = pairs[2 * p], pairs[2 * p + 1]
        dx, dz = float(moved[2, i]) - moved[2, j], float(moved[3, i]) - moved[3, j]
        d = math.sqrt(dx * dx + dz * dz)
        over = float(sorted_[4, i]) + float(sorted_[4, j]) + SPARE - d
        if over > 0.0:
            nx, nz = (dx / d, dz / d) if d > 1e-6 else (1.0, 0.0)
            worst = max(worst, over)
            mi, mj = max(2.0 - sorted_[5, i], LEAST_SHARE), max(2.0 - sorted_[5, j], LEAST_SHARE)
            share = over * mi / (mi + mj)
            change[0, i] += share * nx
            change[1, i] += share * nz
            change[2, i] += 1.0
            share = over * mj / (mi + mj)
            change[0, j] -= share * nx
            change[1, j] -= share * nz
            change[2, j] += 1.0
    return worst


@kernel("void(f4[:,::1], f4[:,::1], i4[::1], i8, f4[:,::1], i8, f4[:,::1], i8, f4[:,::1], i8)")
def part_bodies(
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
    """Move the new places in `moved` (rows 2, 3) apart until no bodies overlap, nor walls nor obstacles."""
    for turn in range(PARTING_ROUNDS):
        for s in range(n):
            change[0, s], change[1, s], change[2, s] = 0.0, 0.0, 0.0
        worst = _push_apart(moved, sorted_, pairs, pair_count, change)
        if worst < 1e-4 and (turn > 0 or wall_count + obstacle_count == 0):
            return
        for s in range(n):
            scale = 1.0 if change[2, s] < 1.5 else 1.5 / change[2, s]
            x, z = moved[2, s] + change[0, s] * scale, moved[3, s] + change[1, s] * scale
            if wall_count + obstacle_count > 0:
                x, z = outside_surroundings(
                    x, z, sorted_[0, s], sorted_[1, s], sorted_[4, s], walls, wall_count, obstacles, obstacle_count
                )
            moved[2, s], moved[3, s] = x, z
