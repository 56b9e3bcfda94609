"""Kernels of parting paths: pairs who would touch on their ways through a measure, and who touch now."""

import math

import numpy as np
import numpy.typing as npt

from live.agents.behaviours.kernels import hash_unit
from live.agents.parting.kernels import NEIGHBOUR_RANGE, cell_count, sort_into_cells
from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int8 = npt.NDArray[np.int8]
Int32 = npt.NDArray[np.int32]

LEAST_SHARE = 0.08
"""A correction of which less than this has come in by then changes nothing."""
AT_ONCE = 0.7
"""Share of what two lack that one round makes good: several pairs want something of the same dancer."""


@kernel("void(f4[::1], f4[::1], i1[::1], i8)")
def leave_out(yields: Float32, responsibility: Float32, state: Int8, there: int) -> None:
    """Write `yields` (A,): the `responsibility` (A,) of those whose `state` (A,) is `there`, -1 for all others."""
    for n in range(yields.shape[0]):
        yields[n] = responsibility[n] if state[n] == there else np.float32(-1.0)


@kernel("f8(f4, f8)")
def weight_of(share: float, begun: float) -> float:
    """How much a change of the correction, made when the share `begun` was in, moves who has `share` of it in."""
    return max(share - begun, 0.0) / max(1.0 - begun, 1e-9)


@kernel("void(f4[:,:,::1], f4[:,::1], f8[:,::1], f8[:,::1], f8, f4[:,::1])")
def walk_paths(path: Float32, share: Float32, goal: Float64, aimed: Float64, place: float, out: Float32) -> None:
    """Where A dancers are at `place` of their paths' M moments (a fraction of an index), `out` (A, 2) [m].

    `path` (A, M, 2) without the corrections, of which `share` (A, M) is in; `goal` (A, 2) is what they lead to, and
    `aimed` (A, 3) as in `Danced`.
    """
    last = path.shape[1] - 1
    k = min(max(math.floor(place), 0), last - 1)
    t = min(max(place - k, 0.0), 1.0)
    for n in range(path.shape[0]):
        w = weight_of((1.0 - t) * share[n, k] + t * share[n, k + 1], aimed[n, 2])
        for c in range(2):
            base = (1.0 - t) * path[n, k, c] + t * path[n, k + 1, c]
            out[n, c] = base + aimed[n, c] + w * (goal[n, c] - aimed[n, c])


@kernel(
    "void(f4[:,:,::1], f4[:,::1], f8[:,::1], f8[:,::1], f8, f4[:,:,::1], f4[:,::1], f8[:,::1], f8[:,::1], f8,"
    " f4[:,::1], f4[:,::1], f4[:,::1])"
)
def walk_on(
    path: Float32, share: Float32, goal: Float64, aimed: Float64, place: float,
    later_path: Float32, later_share: Float32, later_goal: Float64, later_aimed: Float64, later_place: float,
    now: Float32, before: Float32, out: Float32,
) -> None:  # fmt: skip
    """Where A dancers who are `now` (A, 2) [m] get, `out` (A, 2) [m], by what paths lead them from `place` to another.

    Each place is on paths of its own, as in `walk_paths`; `before` (A, 2) is room to work in.
    """
    walk_paths(path, share, goal, aimed, place, before)
    walk_paths(later_path, later_share, later_goal, later_aimed, later_place, out)
    for n in range(out.shape[0]):
        out[n, 0] += now[n, 0] - before[n, 0]
        out[n, 1] += now[n, 1] - before[n, 1]


@kernel("void(f4[:,:,::1], i8, f4[:,::1], f4[::1])")
def span_paths(path: Float32, first: int, middle: Float32, extent: Float32) -> None:
    """Middle (A, 2) and half size (A,) [m] of the box around the paths (A, M, 2) from moment `first` on."""
    for n in range(path.shape[0]):
        low_x = high_x = path[n, first, 0]
        low_z = high_z = path[n, first, 1]
        for m in range(first + 1, path.shape[1]):
            low_x, high_x = min(low_x, path[n, m, 0]), max(high_x, path[n, m, 0])
            low_z, high_z = min(low_z, path[n, m, 1]), max(high_z, path[n, m, 1])
        middle[n, 0], middle[n, 1] = 0.5 * (low_x + high_x), 0.5 * (low_z + high_z)
        extent[n] = 0.5 * max(high_x - low_x, high_z - low_z)


@kernel(
    "UniTuple(f8,5)(f4[:,:,::1], f4[:,::1], f8[:,::1], f8[:,::1], i8, i8, i8, f8, f8, i8)",
)
def nearest_of(
    path: Float32,
    share: Float32,
    goal: Float64,
    aimed: Float64,
    i: int,
    j: int,
    first: int,
    gap: float,
    gap_at_end: float,
    seed: int,
) -> tuple[float, float, float, float, float]:
    """Where two dancers lack most of the `gap` [m] between them: what they lack [m] (below 0: nothing), the direction
    from i to j there, and how much a change of their corrections moves each of them. At the end the gap is wider."""
    worst, nx, nz, wi, wj = -1e9, 0.0, 0.0, 0.0, 0.0
    bx, bz, before_i, before_j = 0.0, 0.0, 0.0, 0.0
    for m in range(first, path.shape[1]):
        ui, uj = weight_of(share[i, m], aimed[i, 2]), weight_of(share[j, m], aimed[j, 2])
        x = path[j, m, 0] + aimed[j, 0] + uj * (goal[j, 0] - aimed[j, 0])
        x -= path[i, m, 0] + aimed[i, 0] + ui * (goal[i, 0] - aimed[i, 0])
        z = path[j, m, 1] + aimed[j, 1] + uj * (goal[j, 1] - aimed[j, 1])
        z -= path[i, m, 1] + aimed[i, 1] + ui * (goal[i, 1] - aimed[i, 1])
        cx, cz, t = x, z, 1.0
        if m > first:  # the nearest point of the straight way since the moment before
            dx, dz = x - bx, z - bz
            size = dx * dx + dz * dz
            if size > 1e-12:
                t = min(max(-(bx * dx + bz * dz) / size, 0.0), 1.0)
            cx, cz = bx + t * dx, bz + t * dz
        lack = gap - math.sqrt(cx * cx + cz * cz)
        if m == path.shape[1] - 1:
            at_end = gap_at_end - math.sqrt(x * x + z * z)
            if at_end > lack:
                lack, cx, cz, t = at_end, x, z, 1.0
        if lack > worst:
            worst, nx, nz = lack, cx, cz
            wi, wj = before_i + t * (ui - before_i), before_j + t * (uj - before_j)
            if m == first:
                wi, wj = ui, uj
        bx, bz, before_i, before_j = x, z, ui, uj
    d = math.sqrt(nx * nx + nz * nz)
    if d < 1e-4:
        angle = 2.0 * math.pi * hash_unit(seed, i, j)
        return worst, math.sin(angle), math.cos(angle), wi, wj
    return worst, nx / d, nz / d, wi, wj


@kernel("void(f8[:,::1], i8, f8, f8, f8)")
def lead_goal(goal: Float64, n: int, dx: float, dz: float, most: float) -> None:
    """Change one goal by (dx, dz) [m]; it gets no longer than `most` [m], nor longer than it was if it was longer."""
    before = math.sqrt(goal[n, 0] * goal[n, 0] + goal[n, 1] * goal[n, 1])
    goal[n, 0] += dx
    goal[n, 1] += dz
    size = math.sqrt(goal[n, 0] * goal[n, 0] + goal[n, 1] * goal[n, 1])
    scale = min(1.0, max(most, before) / max(size, 1e-9))
    goal[n, 0] *= scale
    goal[n, 1] *= scale


@kernel(
    "void(f4[:,:,::1], f4[:,::1], f8[:,::1], f8[:,::1], i8, f4[::1], f4[::1], f8[::1], f8, f8, f8, f8, i8,"
    " f4[:,::1], f4[::1], i4[::1], i4[::1], f4[::1])"
)
def part_paths(
    path: Float32,
    share: Float32,
    goal: Float64,
    aimed: Float64,
    first: int,
    radius: Float32,
    yields: Float32,
    most: Float64,
    margin: float,
    margin_at_end: float,
    half_width: float,
    half_depth: float,
    seed: int,
    middle: Float32,
    extent: Float32,
    cell_start: Int32,
    order: Int32,
    lack: Float32,
) -> None:
    """One round: change the corrections' `goal` (A, 2) [m] so that paths stay apart from moment `first` on.

    `path`, `share`, `aimed` as in `walk_paths`; `radius` (A,) [m] of the bodies, between which there shall be
    `margin` [m] and at the end `margin_at_end`; `yields` (A,): 1 who gives way, 0 to whom others do, below 0 who is not
    there; `most` (A,) [m]: how long a correction may become. `lack` (A,) says how much each dancer lacks at most [m]
    before this round; `middle`, `extent`, `cell_start` and `order` are room to work in.
    """
    columns, rows = cell_count(2.0 * half_width, NEIGHBOUR_RANGE), cell_count(2.0 * half_depth, NEIGHBOUR_RANGE)
    span_paths(path, first, middle, extent)
    sort_into_cells(middle, half_width, half_depth, NEIGHBOUR_RANGE, cell_start, order)
    lack[:] = np.float32(-1.0)
    for i in range(path.shape[0]):
        if yields[i] < 0.0:
            continue
        column = min(max(math.floor((middle[i, 0] + half_width) / NEIGHBOUR_RANGE), 0), columns - 1)
        row = min(max(math.floor((middle[i, 1] + half_depth) / NEIGHBOUR_RANGE), 0), rows - 1)
        for r in range(max(row - 1, 0), min(row + 2, rows)):
            for c in range(max(column - 1, 0), min(column + 2, columns)):
                for k in range(cell_start[r * columns + c], cell_start[r * columns + c + 1]):
                    j = order[k]
                    if j <= i or yields[j] < 0.0:
                        continue
                    bodies = radius[i] + radius[j]
                    near = extent[i] + extent[j] + bodies + margin_at_end + most[i] + most[j]
                    if abs(middle[i, 0] - middle[j, 0]) > near or abs(middle[i, 1] - middle[j, 1]) > near:
                        continue
                    short, nx, nz, wi, wj = nearest_of(
                        path, share, goal, aimed, i, j, first, bodies + margin, bodies + margin_at_end, seed
                    )
                    lack[i], lack[j] = max(lack[i], short), max(lack[j], short)
                    if short <= 0.0:
                        continue
                    own, other = yields[i], yields[j]
                    if own + other <= 0.0:
                        own = other = np.float32(1.0)
                    wi, wj = (wi if wi > LEAST_SHARE else 0.0), (wj if wj > LEAST_SHARE else 0.0)
                    force = AT_ONCE * short / max(own * wi * wi + other * wj * wj, 0.05)
                    lead_goal(goal, i, -force * own * wi * nx, -force * own * wi * nz, most[i])
                    lead_goal(goal, j, force * other * wj * nx, force * other * wj * nz, most[j])


@kernel("b1(f8[:,::1], f8[:,::1], f8, f8)")
def _follow(moved: Float64, speed: Float64, stiffness: float, dt: float) -> bool:
    """Make of what is needed, `moved` (A, 2) [m], the move of this tick: critically damped springs from rest.

    Returns whether anybody is moved.
    """
    fall, any_moved = math.exp(-stiffness * dt), False
    for n in range(moved.shape[0]):
        for c in range(2):
            need, v = min(max(moved[n, c], -0.4), 0.4), speed[n, c]
            if need == 0.0 and abs(v) < 1e-4:
                speed[n, c] = 0.0
                continue
            bend = v - stiffness * need
            moved[n, c] = need + fall * (-need + bend * dt)
            speed[n, c] = fall * (v - stiffness * bend * dt)
            any_moved |= moved[n, c] != 0.0
    return any_moved


@kernel("b1(f4[:,::1], f4[:,::1], f4[::1], f4[::1], f8, f8, f8, f8, f8, i8, i4[::1], i4[::1], f8[:,::1], f8[:,::1])")
def push_apart(
    now: Float32,
    soon: Float32,
    radius: Float32,
    yields: Float32,
    margin: float,
    stiffness: float,
    dt: float,
    half_width: float,
    half_depth: float,
    seed: int,
    cell_start: Int32,
    order: Int32,
    speed: Float64,
    moved: Float64,
) -> bool:
    """The last resort of one tick `dt` [s]: who touches, or will `soon`, is moved away, whatever her feet do.

    `now` and `soon` (A, 2) [m]: where the hips are, and where they will be in a moment; `speed` (A, 2) [m/s] of these
    moves is kept from tick to tick and follows what lacks critically damped, with `stiffness` [1/s]; `moved` (A, 2) [m]
    is this tick's move; returns whether anybody has one. Else as in `part_paths`.
    """
    columns, rows = cell_count(2.0 * half_width, NEIGHBOUR_RANGE), cell_count(2.0 * half_depth, NEIGHBOUR_RANGE)
    sort_into_cells(soon, half_width, half_depth, NEIGHBOUR_RANGE, cell_start, order)
    moved[:] = 0.0
    for i in range(now.shape[0]):
        if yields[i] < 0.0:
            continue
        column = min(max(math.floor((soon[i, 0] + half_width) / NEIGHBOUR_RANGE), 0), columns - 1)
        row = min(max(math.floor((soon[i, 1] + half_depth) / NEIGHBOUR_RANGE), 0), rows - 1)
        for r in range(max(row - 1, 0), min(row + 2, rows)):
            for c in range(max(column - 1, 0), min(column + 2, columns)):
                for k in range(cell_start[r * columns + c], cell_start[r * columns + c + 1]):
                    j = order[k]
                    if j <= i or yields[j] < 0.0:
                        continue
                    gap = radius[i] + radius[j] + margin
                    nx, nz = now[j, 0] - now[i, 0], now[j, 1] - now[i, 1]
                    dx, dz = soon[j, 0] - soon[i, 0] - nx, soon[j, 1] - soon[i, 1] - nz
                    way = dx * dx + dz * dz
                    t = min(max(-(nx * dx + nz * dz) / max(way, 1e-9), 0.0), 1.0)
                    dx, dz = nx + t * dx, nz + t * dz  # where they are nearest
                    d, size = math.sqrt(dx * dx + dz * dz), math.sqrt(nx * nx + nz * nz)
                    if d >= gap:
                        continue
                    if size < 1e-4:
                        angle = 2.0 * math.pi * hash_unit(seed, i, j)
                        nx, nz, size = math.sin(angle), math.cos(angle), 1.0
                    nx, nz = nx / size, nz / size
                    # who would have passed through each other is on the other side then
                    short = min(gap - (dx * nx + dz * nz), 0.6)
                    own, other = yields[i], yields[j]
                    if own + other <= 0.0:
                        own = other = np.float32(1.0)
                    part = short / (own + other)
                    moved[i, 0] -= part * own * nx
                    moved[i, 1] -= part * own * nz
                    moved[j, 0] += part * other * nx
                    moved[j, 1] += part * other * nz
    return _follow(moved, speed, stiffness, dt)
