"""Kernels of path separation: pairs who would touch on their paths through a measure, and pairs who touch now."""

import math

import numpy as np
import numpy.typing as npt

from live.agents.separation.separation_kernels import NEIGHBOUR_RANGE, cell_count, sort_into_cells
from live.agents.steering_kernels import hash_unit
from live.base.jit import kernel
from live.base.scalar_kernels import ease

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int8 = npt.NDArray[np.int8]
Int32 = npt.NDArray[np.int32]

MIN_SHARE = 0.08
"""A correction with a smaller share applied by then has no effect."""
MAX_APPROACH = 1.6
"""Maximum short-term approach of two dancers [m]."""
BOX_ROUNDING = 1e-4
"""By so much [m] boxes and circles around paths are larger than calculated."""
CORRECTION_SHARE = 0.7
"""Share of the missing distance that one round corrects: several pairs may act on the same dancer."""


@kernel("f8(f4, f8)")
def change_weight(share: float, begun: float) -> float:
    """Return the effect at applied share `share` of a correction change made when the share `begun` was applied."""
    return max(share - begun, 0.0) / max(1.0 - begun, 1e-9)


@kernel("UniTuple(f8,2)(f4[:,:,::1], f4[:,::1], f8[:,::1], f8[:,::1], i8, f8)")
def place_on_path(
    path: Float32, share: Float32, goal: Float64, aim_origin: Float64, n: int, place: float
) -> tuple[float, float]:
    """Return where dancer `n` is [m] at `place` of their path's M moments (a fractional index); straight before it.

    `path` (A, M, 2) is without corrections, of which `share` (A, M) is applied; `goal` (A, 2) is their target, and
    `aim_origin` (A, 3) is as in `Danced`.
    """
    k = min(max(math.floor(place), 0), path.shape[1] - 2)
    t = min(place - k, 1.0)
    w = change_weight((1.0 - t) * share[n, k] + t * share[n, k + 1], aim_origin[n, 2])
    x = (1.0 - t) * path[n, k, 0] + t * path[n, k + 1, 0] + aim_origin[n, 0] + w * (goal[n, 0] - aim_origin[n, 0])
    z = (1.0 - t) * path[n, k, 1] + t * path[n, k + 1, 1] + aim_origin[n, 1] + w * (goal[n, 1] - aim_origin[n, 1])
    return x, z


@kernel(
    "void(f4[:,:,::1], f4[:,::1], f8[:,::1], f8[:,::1], f4[:,:,::1], f4[:,::1], f8[:,::1], f8[:,::1], b1, f8,"
    " f8[::1], f4[:,::1], f4[:,:,::1], i8, i8)"
)
def extrapolate_paths(
    path: Float32, share: Float32, goal: Float64, aim_origin: Float64,
    later_path: Float32, later_share: Float32, later_goal: Float64, later_aim_origin: Float64, has_next: bool,
    window: float, fractions: Float64, now: Float32, out: Float32, begin: int, end: int,
) -> None:  # fmt: skip
    """Write where the dancers begin..end-1 at `now` (A, 2) [m] are led by their paths into `out` (K, A, 2) [m].

    The paths, arrays as in `place_on_path`, are those of this measure and, if `has_next`, of the next one, into which
    the last `window` of this one is blended. `fractions` (K + 1,) are positions in this measure, the first one now;
    above 1 the dancer is in the next measure, or at the end of this one.
    """
    last = path.shape[1] - 1
    for m in range(fractions.shape[0]):
        f = fractions[m]
        into = ease((f - (1.0 - window)) / window) if has_next else 0.0
        for n in range(begin, end):
            x, z = place_on_path(path, share, goal, aim_origin, n, f * last)
            if into > 0.0:
                to_x, to_z = place_on_path(later_path, later_share, later_goal, later_aim_origin, n, (f - 1.0) * last)
                x, z = x + into * (to_x - x), z + into * (to_z - z)
            # until it is filled itself, the last row holds the current places on the paths
            if m == 0:
                out[fractions.shape[0] - 2, n, 0], out[fractions.shape[0] - 2, n, 1] = x, z
                continue
            was_x, was_z = out[fractions.shape[0] - 2, n, 0], out[fractions.shape[0] - 2, n, 1]
            out[m - 1, n, 0], out[m - 1, n, 1] = now[n, 0] + x - was_x, now[n, 1] + z - was_z


@kernel("void(f4[:,:,::1], f4[:,::1], f8[:,::1], f8[:,::1], i8, f4[:,::1], f4[::1])")
def path_bounds(
    path: Float32, share: Float32, goal: Float64, aim_origin: Float64, first: int, middle: Float32, extent: Float32
) -> None:
    """Compute centre (A, 2) and half size (A,) [m] of the boxes around corrected paths from moment `first` on."""
    for n in range(path.shape[0]):
        per = 1.0 / max(1.0 - aim_origin[n, 2], 1e-9)
        way_x, way_z = goal[n, 0] - aim_origin[n, 0], goal[n, 1] - aim_origin[n, 1]
        low_x = low_z = np.inf
        high_x = high_z = -np.inf
        for m in range(first, path.shape[1]):
            w = max(share[n, m] - aim_origin[n, 2], 0.0) * per
            x, z = path[n, m, 0] + w * way_x, path[n, m, 1] + w * way_z
            low_x, high_x = min(low_x, x), max(high_x, x)
            low_z, high_z = min(low_z, z), max(high_z, z)
        middle[n, 0] = 0.5 * (low_x + high_x) + aim_origin[n, 0]
        middle[n, 1] = 0.5 * (low_z + high_z) + aim_origin[n, 1]
        extent[n] = 0.5 * max(high_x - low_x, high_z - low_z) + BOX_ROUNDING


@kernel(
    "UniTuple(f8,5)(f4[:,:,::1], f4[:,::1], f8[:,::1], f8[:,::1], i8, i8, i8, f8, f8, i8)",
)
def largest_shortfall(
    path: Float32,
    share: Float32,
    goal: Float64,
    aim_origin: Float64,
    i: int,
    j: int,
    first: int,
    gap: float,
    gap_at_end: float,
    seed: int,
) -> tuple[float, float, float, float, float]:
    """Find where two dancers lack most of the `gap` [m] between them; at the end of the measure the gap is wider.

    Returns the missing distance [m] (below 0: none), the direction from i to j there, and how much a change of their
    corrections moves each of them.
    """
    worst, nx, nz, wi, wj = -1e9, 0.0, 0.0, 0.0, 0.0
    bx, bz, before_i, before_j = 0.0, 0.0, 0.0, 0.0
    own, other = aim_origin[i], aim_origin[j]
    own_x, own_z, other_x, other_z = (
        goal[i, 0] - own[0],
        goal[i, 1] - own[1],
        goal[j, 0] - other[0],
        goal[j, 1] - other[1],
    )
    off_x, off_z = other[0] - own[0], other[1] - own[1]
    per_i, per_j = 1.0 / max(1.0 - own[2], 1e-9), 1.0 / max(1.0 - other[2], 1e-9)
    for m in range(first, path.shape[1]):
        ui, uj = max(share[i, m] - own[2], 0.0) * per_i, max(share[j, m] - other[2], 0.0) * per_j
        x = path[j, m, 0] - path[i, m, 0] + off_x + uj * other_x - ui * own_x
        z = path[j, m, 1] - path[i, m, 1] + off_z + uj * other_z - ui * own_z
        cx, cz, t = x, z, 1.0
        if m > first:  # the nearest point of the straight segment since the moment before
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
def move_goal(goal: Float64, n: int, dx: float, dz: float, max_length: float) -> None:
    """Change one goal by (dx, dz) [m]; its length stays within `max_length` [m], or its old length if larger."""
    before = math.sqrt(goal[n, 0] * goal[n, 0] + goal[n, 1] * goal[n, 1])
    goal[n, 0] += dx
    goal[n, 1] += dz
    size = math.sqrt(goal[n, 0] * goal[n, 0] + goal[n, 1] * goal[n, 1])
    scale = min(1.0, max(max_length, before) / max(size, 1e-9))
    goal[n, 0] *= scale
    goal[n, 1] *= scale


@kernel(
    "void(f4[:,:,::1], f4[:,::1], f8[:,::1], f8[:,::1], i8, f4[::1], f4[::1], f8[::1], f8, f8, f8, f8, i8,"
    " f4[:,::1], f4[::1], i4[::1], i4[::1], f4[::1])"
)
def separate_paths(
    path: Float32,
    share: Float32,
    goal: Float64,
    aim_origin: Float64,
    first: int,
    radius: Float32,
    yields: Float32,
    max_correction: Float64,
    margin: float,
    margin_at_end: float,
    half_width: float,
    half_depth: float,
    seed: int,
    middle: Float32,
    extent: Float32,
    cell_start: Int32,
    order: Int32,
    shortfall: Float32,
) -> None:
    """Do one round: change the corrections' `goal` (A, 2) [m] so that paths stay apart from moment `first` on.

    `path`, `share`, `aim_origin` as in `place_on_path`; `radius` (A,) [m] of the bodies, which keep `margin` [m] and
    at the end `margin_at_end`; `yields` (A,): 1 gives way, 0 has the right of way, below 0 is absent; `max_correction`
    (A,) [m]: maximum length of a correction. `shortfall` (A,) receives the largest missing distance [m] of each dancer
    before this round; `middle`, `extent`, `cell_start` and `order` are scratch.
    """
    columns, rows = cell_count(2.0 * half_width, NEIGHBOUR_RANGE), cell_count(2.0 * half_depth, NEIGHBOUR_RANGE)
    path_bounds(path, share, goal, aim_origin, first, middle, extent)
    sort_into_cells(middle, half_width, half_depth, NEIGHBOUR_RANGE, cell_start, order)
    for i in range(path.shape[0]):
        shortfall[i] = -1.0
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
                    near = extent[i] + extent[j] + bodies + max(margin, margin_at_end)
                    if abs(middle[i, 0] - middle[j, 0]) > near or abs(middle[i, 1] - middle[j, 1]) > near:
                        continue
                    short, nx, nz, wi, wj = largest_shortfall(
                        path, share, goal, aim_origin, i, j, first, bodies + margin, bodies + margin_at_end, seed
                    )
                    shortfall[i], shortfall[j] = max(shortfall[i], short), max(shortfall[j], short)
                    if short <= 0.0:
                        continue
                    own, other = yields[i], yields[j]
                    if own + other <= 0.0:
                        own = other = np.float32(1.0)
                    wi, wj = (wi if wi > MIN_SHARE else 0.0), (wj if wj > MIN_SHARE else 0.0)
                    force = CORRECTION_SHARE * short / max(own * wi * wi + other * wj * wj, 0.05)
                    move_goal(goal, i, -force * own * wi * nx, -force * own * wi * nz, max_correction[i])
                    move_goal(goal, j, force * other * wj * nx, force * other * wj * nz, max_correction[j])
                    extent[i] += force * own * wi  # no place on a path moves farther than its goal
                    extent[j] += force * other * wj


@kernel("b1(f8[:,::1], f8[:,::1], f8, f8)")
def _follow(moved: Float64, speed: Float64, stiffness: float, dt: float) -> bool:
    """Turn the required displacement `moved` (A, 2) [m] into this tick's move: critically damped springs from rest.

    Returns whether any dancer is moved.
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


@kernel("void(f4[:,::1], f8[:,::1], f8[:,::1], i8, i8, f8, f8)")
def _slow_down(now: Float32, moved: Float64, speed: Float64, i: int, j: int, bodies: float, margin: float) -> None:
    """Slow two dancers nearer than their `bodies` and the `margin` [m] in moving towards each other.

    The nearer they are, the less of `moved` and `speed` (A, 2) towards each other remains. This includes moves caused
    by a third dancer who pushes one of them.
    """
    nx, nz = now[j, 0] - now[i, 0], now[j, 1] - now[i, 1]
    size = math.sqrt(nx * nx + nz * nz)
    if size >= bodies + margin or size < 1e-4:
        return
    nx, nz, stop = nx / size, nz / size, 1.0 - max(size - bodies, 0.0) / margin
    for way in (moved, speed):
        own, other = way[i, 0] * nx + way[i, 1] * nz, way[j, 0] * nx + way[j, 1] * nz
        if own <= other:
            continue  # they separate
        # each dancer's contribution to the approach is slowed down
        close = stop * (own - other) / max(max(own, 0.0) + max(-other, 0.0), 1e-12)
        off, on = close * max(own, 0.0), close * max(-other, 0.0)
        way[i, 0] -= off * nx
        way[i, 1] -= off * nz
        way[j, 0] += on * nx
        way[j, 1] += on * nz


@kernel("void(f4[:,::1], f4[::1], f4[::1], f8, f8, f8, i4[::1], i4[::1], f8[:,::1], f8[:,::1])")
def slow_down_near(
    now: Float32, radius: Float32, yields: Float32, margin: float, half_width: float, half_depth: float,
    cell_start: Int32, order: Int32, speed: Float64, moved: Float64,
) -> None:  # fmt: skip
    """After `push_apart` (same arrays): prevent that a dancer pushed by one neighbour is `moved` into another."""
    columns, rows = cell_count(2.0 * half_width, NEIGHBOUR_RANGE), cell_count(2.0 * half_depth, NEIGHBOUR_RANGE)
    for i in range(now.shape[0]):
        if yields[i] < 0.0:
            continue
        column = min(max(math.floor((now[i, 0] + half_width) / NEIGHBOUR_RANGE), 0), columns - 1)
        row = min(max(math.floor((now[i, 1] + half_depth) / NEIGHBOUR_RANGE), 0), rows - 1)
        for r in range(max(row - 1, 0), min(row + 2, rows)):
            for c in range(max(column - 1, 0), min(column + 2, columns)):
                for k in range(cell_start[r * columns + c], cell_start[r * columns + c + 1]):
                    if order[k] > i and yields[order[k]] >= 0.0:
                        _slow_down(now, moved, speed, i, order[k], radius[i] + radius[order[k]], margin)


@kernel("f8(f4[:,::1], f4[:,:,::1], i8, i8, f8, f8, f8)")
def predicted_shortfall(now: Float32, soon: Float32, i: int, j: int, gap: float, nx: float, nz: float) -> float:
    """Return the largest shortfall of `gap` [m] of two dancers on straight paths from `now` (A, 2) to `soon` (K, A, 2).

    It is measured in the direction (nx, nz) from i to j [m]; 0: none.
    """
    worst = 0.0
    x, z = now[j, 0] - now[i, 0], now[j, 1] - now[i, 1]
    for k in range(soon.shape[0]):
        dx, dz = soon[k, j, 0] - soon[k, i, 0] - x, soon[k, j, 1] - soon[k, i, 1] - z
        t = min(max(-(x * dx + z * dz) / max(dx * dx + dz * dz, 1e-9), 0.0), 1.0)
        cx, cz = x + t * dx, z + t * dz  # their nearest approach
        # dancers who would have passed through each other are then on the opposite side
        if cx * cx + cz * cz < gap * gap:
            worst = max(worst, gap - (cx * nx + cz * nz))
        x, z = x + dx, z + dz
    return worst


@kernel("f8[::1](f4[:,::1], f4[:,:,::1])")
def _largest_moves(now: Float32, soon: Float32) -> Float64:
    """Return how far each dancer gets (A,) [m] from the place `now` (A, 2) at the moments `soon` (K, A, 2)."""
    away = np.zeros(now.shape[0])
    for k in range(soon.shape[0]):
        for n in range(now.shape[0]):
            x, z = soon[k, n, 0] - now[n, 0], soon[k, n, 1] - now[n, 1]
            away[n] = max(away[n], math.sqrt(x * x + z * z))
    return away


@kernel("b1(f4[:,::1], f4[:,:,::1], f4[::1], f4[::1], f8, f8, f8, f8, f8, i8, i4[::1], i4[::1], f8[:,::1], f8[:,::1])")
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
    """Last resort of one tick `dt` [s]: move dancers apart who touch, or will `soon`, regardless of their feet.

    `now` (A, 2) and `soon` (K, A, 2) [m] are hip places now and at some moments soon. `speed` (A, 2) [m/s] of these
    moves is kept between ticks and follows the missing distance critically damped, with `stiffness` [1/s]; `moved`
    (A, 2) [m] is this tick's move. Returns whether there is any. The rest as in `separate_paths`.
    """
    columns, rows = cell_count(2.0 * half_width, NEIGHBOUR_RANGE), cell_count(2.0 * half_depth, NEIGHBOUR_RANGE)
    sort_into_cells(now, half_width, half_depth, NEIGHBOUR_RANGE, cell_start, order)
    for i in range(moved.shape[0]):
        moved[i, 0] = moved[i, 1] = 0.0
    away = _largest_moves(now, soon)
    for i in range(now.shape[0]):
        if yields[i] < 0.0:
            continue
        column = min(max(math.floor((now[i, 0] + half_width) / NEIGHBOUR_RANGE), 0), columns - 1)
        row = min(max(math.floor((now[i, 1] + half_depth) / NEIGHBOUR_RANGE), 0), rows - 1)
        for r in range(max(row - 1, 0), min(row + 2, rows)):
            for c in range(max(column - 1, 0), min(column + 2, columns)):
                for k in range(cell_start[r * columns + c], cell_start[r * columns + c + 1]):
                    j = order[k]
                    if j <= i or yields[j] < 0.0:
                        continue
                    gap = radius[i] + radius[j] + margin
                    nx, nz = now[j, 0] - now[i, 0], now[j, 1] - now[i, 1]
                    size = math.sqrt(nx * nx + nz * nz)
                    if size > gap + min(away[i] + away[j] + BOX_ROUNDING, MAX_APPROACH):
                        continue
                    if size < 1e-4:
                        angle = 2.0 * math.pi * hash_unit(seed, i, j)
                        nx, nz, size = math.sin(angle), math.cos(angle), 1.0
                    nx, nz = nx / size, nz / size
                    short = min(predicted_shortfall(now, soon, i, j, gap, nx, nz), 0.6)
                    if short <= 0.0:
                        continue
                    own, other = yields[i], yields[j]
                    if own + other <= 0.0:
                        own = other = np.float32(1.0)
                    part = short / (own + other)
                    moved[i, 0] -= part * own * nx
                    moved[i, 1] -= part * own * nz
                    moved[j, 0] += part * other * nx
                    moved[j, 1] += part * other * nz
    return _follow(moved, speed, stiffness, dt)
