"""Narrow passages: gaps between walls that only one person fits through, and the right of way in them.

Two opposite streams block each other in a door: each agent avoids collisions, and nobody goes back. So a passage is
used in one direction at a time. Who is in it, or else the nearest one who wants to pass, gives the direction; the
others wait beside the way out. The rule looks at the present tick only: there is no state.
"""

import math

import numpy as np
import numpy.typing as npt

from live.agents.crowd.contact_kernels import wall_offset
from live.agents.crowd.spatial_grid_kernels import MOBILITY, RADIUS, X, Z
from live.base.jit import inline_kernel, kernel

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

PASSAGES = 16
"""Largest number of passages."""
PASSAGE_COLUMNS = 6
"""x and z of the middle [m], direction of the way through (unit vector), half length and half width [m]."""
LEAST_WIDTH, SINGLE_FILE, NARROW = 0.45, 1.1, 2.05
"""Width of a gap [m] that somebody fits through, of one that two do not fit through side by side, and of one in which
opposite streams hinder each other so much that taking turns is faster.
"""
DOOR_DEPTH = 1.5
"""Length of a passage [m] up to which it is a door. In longer ones, unless for a single file, there are lanes."""
MERGED = 0.7
"""Passages so near each other [m], in one direction, are one."""
CLEARANCE = 1.2
"""Those who wait stay so far away from the mouth [m]."""
WAY_OUT = 2.5
"""Length of the way out of a passage that is kept free [m]."""
WAY_OUT_MARGIN = 0.45
"""By so much the way out is wider than the passage, on each side [m]."""
RANGE = 3.0
"""Distance from the mouth [m] within which agents heed the right of way."""
STOP = 0.4
"""Those who wait stop so far from the way out [m]."""
_AIM = 0.3
"""Who passes the middle of the gap by less than this beyond its edge [m] wants to go through."""


@kernel("void(f4[::1],f8,f8,f8,f8)")
def _extend(passage: Float32, mx: float, mz: float, half: float, half_width: float) -> None:
    """Extend a passage by another one in its line, with the middle (mx, mz) and half its length and width [m]."""
    ax, az = float(passage[2]), float(passage[3])
    along = (mx - passage[0]) * ax + (mz - passage[1]) * az
    low, high = min(-float(passage[4]), along - half), max(float(passage[4]), along + half)
    passage[0] += 0.5 * (low + high) * ax
    passage[1] += 0.5 * (low + high) * az
    passage[4], passage[5] = 0.5 * (high - low), min(passage[5], half_width)


@kernel("b1(f4[:,::1],i8,i8,f4[::1])")
def _passage_between(walls: Float32, w: int, v: int, found: Float32) -> bool:
    """Write the narrow passage between two walls into `found` (PASSAGE_COLUMNS,); return whether there is one.

    Two walls are nearest to each other at an end of one of them, if they do not come nearer from there on. Between
    parallel walls there are two such places, and the passage is the way between them.
    """
    there = False
    for k in range(4):
        of, to, end = w if k < 2 else v, v if k < 2 else w, 2 * (k % 2)
        x, z = float(walls[of, end]), float(walls[of, end + 1])
        dx, dz = wall_offset(x, z, walls, to)
        width = math.sqrt(dx * dx + dz * dz)
        if width < LEAST_WIDTH or width > NARROW:
            continue
        nx, nz, mx, mz = -dz / width, dx / width, x - 0.5 * dx, z - 0.5 * dz
        on_x, on_z = walls[of, 2 - end] - x, walls[of, 3 - end] - z
        if -(dx * on_x + dz * on_z) > 0.1 * width * math.sqrt(on_x * on_x + on_z * on_z):
            continue
        if not there:
            found[0], found[1], found[2], found[3], found[4], found[5] = mx, mz, nx, nz, 0.0, 0.5 * width
            there = True
        else:
            _extend(found, mx, mz, 0.0, 0.5 * width)
    return there


@kernel("i8(f4[:,::1],i8,f4[:,::1])")
def find_passages(walls: Float32, wall_count: int, passages: Float32) -> int:
    """Write the narrow passages between the first `wall_count` of `walls` (W, 4) [m]; return their number.

    Passages in one line are one, as those between the faces of two thick walls.
    """
    count, kept = 0, 0
    new = np.empty(PASSAGE_COLUMNS, np.float32)
    for w in range(wall_count):
        for v in range(w):
            if not _passage_between(walls, w, v, new):
                continue
            p = 0
            while p < count:
                old = passages[p]
                ox, oz = new[0] - old[0], new[1] - old[1]
                along, across = abs(ox * old[2] + oz * old[3]), abs(oz * old[2] - ox * old[3])
                parallel = abs(new[2] * old[2] + new[3] * old[3]) > 0.8
                if parallel and across < new[5] and along < new[4] + old[4] + MERGED:
                    break
                p += 1
            if p < count:
                _extend(passages[p], new[0], new[1], new[4], new[5])
            elif count < PASSAGES:
                passages[count] = new
                count += 1
    for p in range(count):
        if passages[p, 4] <= 0.5 * DOOR_DEPTH or 2.0 * passages[p, 5] <= SINGLE_FILE:
            passages[kept] = passages[p]
            kept += 1
    return kept


@inline_kernel
def _approach(
    sorted_: Float32, commands: Float32, i: int, s: int, passage: Float32
) -> tuple[float, float, float, float]:
    """Return the direction (1, -1; 0: none) in which agent i in slot s wants to go through a passage, its distance
    from the mouth [m] (below 0: inside; the farther, the less), and its place along and across the passage [m].
    """
    nx, nz, half, wide = float(passage[2]), float(passage[3]), float(passage[4]), float(passage[5])
    x, z = float(sorted_[X, s]) - passage[0], float(sorted_[Z, s]) - passage[1]
    along, across = x * nx + z * nz, z * nx - x * nz
    wish_x, wish_z = float(commands[8 * i]), float(commands[8 * i + 1])
    forth, sideways = wish_x * nx + wish_z * nz, wish_z * nx - wish_x * nz
    way = 1.0 if forth > 0.0 else -1.0
    before = -along * way - half  # distance from the mouth along the way
    radius = float(sorted_[RADIUS, s])
    if before > RANGE or before < -2.0 * half - radius or abs(forth) < 1e-3:
        return 0.0, 0.0, along, across
    if before <= radius:
        inside = abs(across) < wide + 0.1
        return way if inside else 0.0, before - radius, along, across
    meets = across + sideways / abs(forth) * before
    if abs(meets) > wide + _AIM:
        return 0.0, 0.0, along, across
    return way, math.sqrt(before * before + across * across), along, across


@kernel("void(f4[::1],f4[:,::1],i4[::1],i8,f4[:,::1],i8)")
def give_way(
    commands: Float32, sorted_: Float32, slot_agent: Int32, n: int, passages: Float32, passage_count: int
) -> None:
    """Let those wait who want to go through a passage against its present direction. commands (8 A,), changed."""
    for p in range(passage_count):
        passage = passages[p]
        half, wide = float(passage[4]), float(passage[5])
        first, chosen, waiting = 1e9, 0.0, 0
        for s in range(n):
            way, distance, _, _ = _approach(sorted_, commands, slot_agent[s], s, passage)
            if way == 0.0:
                continue
            waiting |= 1 if way > 0.0 else 2
            if distance < first:
                first, chosen = distance, way
        if waiting != 3:
            continue
        nx, nz = float(passage[2]), float(passage[3])
        for s in range(n):
            i = slot_agent[s]
            way, distance, along, across = _approach(sorted_, commands, i, s, passage)
            if way != -chosen:
                continue
            wish_x, wish_z = float(commands[8 * i]), float(commands[8 * i + 1])
            speed = math.sqrt(wish_x * wish_x + wish_z * wish_z)
            before = -along * way - half
            clear = wide + WAY_OUT_MARGIN
            back, aside = 0.0, 0.0
            if distance < CLEARANCE or (abs(across) < clear and before < WAY_OUT):
                side = way if abs(across) < 0.1 else math.copysign(1.0, across)
                back = 1.0 if before < float(sorted_[RADIUS, s]) + 0.2 else 0.35
                aside = side * (0.0 if before < 0.0 else 1.0)
                size = speed / math.sqrt(back * back + aside * aside)
                back, aside = back * size, aside * size
            elif distance > CLEARANCE + STOP and (abs(across) > clear + STOP or before > WAY_OUT + STOP):
                continue  # still far enough away
            commands[8 * i] = -way * back * nx - aside * nz
            commands[8 * i + 1] = -way * back * nz + aside * nx
            sorted_[MOBILITY, s] = max(sorted_[MOBILITY, s] - np.float32(0.9), np.float32(0.1))
