"""Bounds: stage edges, walls and obstacles keep velocities and places in (T107)."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

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
