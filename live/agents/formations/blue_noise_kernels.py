"""Kernels for blue noise with an exact count, even spacing and lattice rows (T091, T144)."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]


@inline_kernel
def neighbour_weight(
    ax: float, az: float, bx: float, bz: float, scale: float, min_distance: float, reach: float
) -> float:
    """Return the weight of a neighbour at b for a dancer at a: (1 - d / reach)^8, 0 beyond `reach`."""
    dx = ax - bx
    dz = az - bz
    squared = (dx * dx + dz * dz) * scale * scale
    if squared >= reach * reach:
        return 0.0
    near = 1.0 - max(math.sqrt(squared), min_distance) / reach
    near *= near
    near *= near
    return near * near


@kernel("void(f8[:,::1], f8[:,::1], f8[:,::1], f8[::1], i8, f8, f8, f8[::1])")
def eliminate(
    points: Float64,
    reflected: Float64,
    fixed: Float64,
    scale: Float64,
    keep: int,
    reach: float,
    min_distance: float,
    weight: Float64,
) -> None:
    """Remove the most crowded of `points` (M, 2) until `keep` are left (Yuksel 2015, weighted sample elimination).

    `reflected` (M, 2) or (0, 2): mirror images of the points, which count as neighbours; `fixed` (F, 2): places that
    stay. Distances are multiplied by `scale` (M,), larger where dancers are denser. Neighbours are weighted by
    `neighbour_weight`, with distances clamped to at least `min_distance` [m]; a point's own image and fixed places
    weigh eight times as much. `weight` (M,) is scratch; afterwards it is negative for removed points.
    """
    count = points.shape[0]
    mirrored = reflected.shape[0] == count
    for i in range(count):
        x = points[i, 0]
        z = points[i, 1]
        total = 0.0
        for j in range(count):
            s = 0.5 * (scale[i] + scale[j])
            if j != i:
                total += neighbour_weight(x, z, points[j, 0], points[j, 1], s, min_distance, reach)
            if mirrored:
                own = 8.0 if j == i else 1.0
                total += own * neighbour_weight(x, z, reflected[j, 0], reflected[j, 1], s, 0.0, reach)
        for f in range(fixed.shape[0]):
            total += 8.0 * neighbour_weight(x, z, fixed[f, 0], fixed[f, 1], scale[i], 0.0, reach)
        weight[i] = total
    for _ in range(count - keep):
        gone = 0
        for i in range(count):
            if weight[i] > weight[gone]:
                gone = i
        weight[gone] = -1.0
        for i in range(count):
            if weight[i] >= 0.0:
                x = points[i, 0]
                z = points[i, 1]
                s = 0.5 * (scale[i] + scale[gone])
                taken = neighbour_weight(x, z, points[gone, 0], points[gone, 1], s, min_distance, reach)
                if mirrored:
                    taken += neighbour_weight(x, z, reflected[gone, 0], reflected[gone, 1], s, 0.0, reach)
                weight[i] = max(weight[i] - taken, 0.0)


@kernel("void(f8[:,::1], f8[::1], f8[:,::1], i8, i8, f8, f8[:,::1], i8[::1])")
def lloyd_relax(
    ground: Float64,
    density: Float64,
    sites: Float64,
    movable: int,
    rounds: int,
    stride: float,
    sums: Float64,
    nearest: Int64,
) -> None:
    """Lloyd's method: move each of the first `movable` of `sites` (S, 2) to the centroid of its nearest ground points.

    `ground` (G, 2): points over the region, each with weight `density` (G,). `stride` 1 moves to the centroid, up to 2
    overshoots and needs fewer rounds. `sums` (S, 3) is scratch; `nearest` (G,) receives the site of each ground point
    before the last move.
    """
    for _ in range(rounds):
        for s in range(sites.shape[0]):
            sums[s, 0] = 0.0
            sums[s, 1] = 0.0
            sums[s, 2] = 0.0
        for g in range(ground.shape[0]):
            best = 0
            least = math.inf
            for s in range(sites.shape[0]):
                dx = ground[g, 0] - sites[s, 0]
                dz = ground[g, 1] - sites[s, 1]
                d = dx * dx + dz * dz
                if d < least:
                    least = d
                    best = s
            nearest[g] = best
            sums[best, 0] += density[g] * ground[g, 0]
            sums[best, 1] += density[g] * ground[g, 1]
            sums[best, 2] += density[g]
        for s in range(movable):
            if sums[s, 2] > 0.0:
                sites[s, 0] += stride * (sums[s, 0] / sums[s, 2] - sites[s, 0])
                sites[s, 1] += stride * (sums[s, 1] / sums[s, 2] - sites[s, 1])


@kernel("i8(f8[:,::1], f8[::1], f8, f8, f8, f8, f8[::1], f8[:,::1])")
def lattice_points_in_polygon(
    edges: Float64,
    bounds: Float64,
    step: float,
    row_step: float,
    x0: float,
    z0: float,
    crossings: Float64,
    out: Float64,
) -> int:
    """Count the points (x0 + i step, z0 + j drop) in a polygon and write the first of them into `out`, front rows
    first.

    `edges` (E, 4): x, z of both ends of all sides, holes included (even-odd), around (0, 0). `bounds`: least and
    greatest z. Points on the border count. `crossings` (E,) is scratch; `out` (K, 2) may be shorter than the result.
    """
    found = 0
    last = math.ceil((bounds[0] - z0) / row_step - 1e-9)
    row = math.floor((bounds[1] - z0) / row_step + 1e-9)
    while row >= last:
        z = z0 + row * row_step
        row -= 1
        at = z - 1e-9 if z > 0.0 else z + 1e-9  # a row on the border counts as inside
        hits = 0
        for e in range(edges.shape[0]):
            if (edges[e, 1] > at) != (edges[e, 3] > at):
                share = (at - edges[e, 1]) / (edges[e, 3] - edges[e, 1])
                x = edges[e, 0] + share * (edges[e, 2] - edges[e, 0])
                k = hits
                while k > 0 and crossings[k - 1] > x:
                    crossings[k] = crossings[k - 1]
                    k -= 1
                crossings[k] = x
                hits += 1
        before = -(1 << 60)
        for h in range(0, hits - 1, 2):
            first = max(
                math.ceil((crossings[h] - x0) / step - 1e-9), before + 1
            )  # touching intervals must not count a point twice
            end = math.floor((crossings[h + 1] - x0) / step + 1e-9)
            for i in range(first, end + 1):
                if found < out.shape[0]:
                    out[found, 0] = x0 + i * step
                    out[found, 1] = z
                found += 1
                before = i
    return found
