"""Kernels that keep corrected paths and moves out of walls and obstacles."""

import math

import numpy as np
import numpy.typing as npt

from live.agents.crowd.contact_kernels import project_outside
from live.agents.separation.path_separation_kernels import change_weight, move_goal
from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]

MIN_SHARE = 0.08
"""A correction with a smaller share applied by then has no effect."""
CORRECTION_SHARE = 0.8
"""Share of the missing distance that one round corrects: other constraints act on the same dancer."""
MAX_DEPTH = 1.0
"""A dancer deeper inside an object than this [m] (it was placed on them) is not led out within one measure."""


@kernel("b1(f4[:,:,::1], i8, i8, f8, f4[:,::1], i8, f4[:,::1], i8)")
def near_obstacles(
    path: Float32,
    n: int,
    first: int,
    reach: float,
    walls: Float32,
    wall_count: int,
    obstacles: Float32,
    obstacle_count: int,
) -> bool:
    """Whether anything is within `reach` [m] of the box around a dancer's path from moment `first` on; rejects most."""
    low_x = high_x = path[n, first, 0]
    low_z = high_z = path[n, first, 1]
    for m in range(first + 1, path.shape[1]):
        low_x, high_x = min(low_x, path[n, m, 0]), max(high_x, path[n, m, 0])
        low_z, high_z = min(low_z, path[n, m, 1]), max(high_z, path[n, m, 1])
    for w in range(wall_count):
        if min(walls[w, 0], walls[w, 2]) > high_x + reach or max(walls[w, 0], walls[w, 2]) < low_x - reach:
            continue
        if min(walls[w, 1], walls[w, 3]) <= high_z + reach and max(walls[w, 1], walls[w, 3]) >= low_z - reach:
            return True
    for o in range(obstacle_count):
        around = reach + obstacles[o, 2]
        if (
            low_x - around <= obstacles[o, 0] <= high_x + around
            and low_z - around <= obstacles[o, 1] <= high_z + around
        ):
            return True
    return False


@kernel(
    "void(f4[:,:,::1], f4[:,::1], f8[:,::1], f8[:,::1], i8, f4[::1], f4[::1], f8[::1], f4[:,::1], i8, f4[:,::1], i8)"
)
def clear_paths(
    path: Float32,
    share: Float32,
    goal: Float64,
    aim_origin: Float64,
    first: int,
    radius: Float32,
    yields: Float32,
    max_correction: Float64,
    walls: Float32,
    wall_count: int,
    obstacles: Float32,
    obstacle_count: int,
) -> None:
    """Do one round: change the corrections' `goal` (A, 2) [m] so that paths avoid walls (64, 4) and obstacles (64, 5).

    Moments from `first` on count. As in `separate_paths`: `path` (A, M, 2), `share` (A, M), `aim_origin` (A, 3),
    `radius` (A,), `yields` (A,) below 0 for absent dancers, `max_correction` (A,) [m]. The moment at which a path is
    farthest inside counts.
    """
    for n in range(path.shape[0]):
        reach = radius[n] + max(max_correction[n], math.sqrt(goal[n, 0] * goal[n, 0] + goal[n, 1] * goal[n, 1]))
        if yields[n] < 0.0 or not near_obstacles(path, n, first, reach, walls, wall_count, obstacles, obstacle_count):
            continue
        worst, x_more, z_more, weight = 1e-4, 0.0, 0.0, 1.0
        old_x, old_z = float(path[n, first, 0]), float(path[n, first, 1])
        for m in range(first + 1, path.shape[1]):
            w = change_weight(share[n, m], aim_origin[n, 2])
            x = path[n, m, 0] + aim_origin[n, 0] + w * (goal[n, 0] - aim_origin[n, 0])
            z = path[n, m, 1] + aim_origin[n, 1] + w * (goal[n, 1] - aim_origin[n, 1])
            out_x, out_z = project_outside(
                x, z, old_x, old_z, float(radius[n]), walls, wall_count, obstacles, obstacle_count
            )
            lack = math.sqrt((out_x - x) * (out_x - x) + (out_z - z) * (out_z - z))
            if lack < 1e-4:  # clear of everything in this direction
                old_x, old_z = x, z
            elif w > MIN_SHARE and worst < lack < MAX_DEPTH:
                worst, x_more, z_more, weight = lack, out_x - x, out_z - z, w
        if worst > 1e-4:
            move_goal(
                goal, n, CORRECTION_SHARE * x_more / weight, CORRECTION_SHARE * z_more / weight, max_correction[n]
            )


@kernel("void(f4[:,::1], f8[:,::1], f4[::1], f4[:,::1], i8, f4[:,::1], i8)")
def clear_moves(
    now: Float32,
    moved: Float64,
    radius: Float32,
    walls: Float32,
    wall_count: int,
    obstacles: Float32,
    obstacle_count: int,
) -> None:
    """Remove from this tick's moves (A, 2) [m] the part that leads from `now` (A, 2) [m] into a wall or an obstacle.

    It removes at most the move itself, so that a dancer whose step has led into an object does not jump.
    """
    for n in range(now.shape[0]):
        size = math.sqrt(moved[n, 0] * moved[n, 0] + moved[n, 1] * moved[n, 1])
        if size < 1e-9:
            continue
        x, z = now[n, 0] + moved[n, 0], now[n, 1] + moved[n, 1]
        out_x, out_z = project_outside(
            x, z, float(now[n, 0]), float(now[n, 1]), float(radius[n]), walls, wall_count, obstacles, obstacle_count
        )
        lack = math.sqrt((out_x - x) * (out_x - x) + (out_z - z) * (out_z - z))
        if lack > 1e-9:
            part = min(size / lack, 1.0)
            moved[n, 0] += part * (out_x - x)
            moved[n, 1] += part * (out_z - z)
