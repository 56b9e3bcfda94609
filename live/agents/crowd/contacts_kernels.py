"""Contacts: bodies that come near slow down towards each other, and never overlap (position based, Jacobi)."""

import math

import numpy as np
import numpy.typing as npt

from live.agents.crowd.bounds_kernels import outside_surroundings
from live.agents.crowd.cells_kernels import RADIUS, X, Z
from live.base.jit import kernel, part

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

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
