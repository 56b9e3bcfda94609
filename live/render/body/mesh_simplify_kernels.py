"""Kernels of edge collapse (Garland and Heckbert 1997) on a triangle mesh that stays closed and symmetric.

A mesh is `triangles` (T, 3), vertices counter-clockwise; one that is gone begins with -1. The corners 3 t + k of each
vertex are a linked list: `first` (V,) and `following` (3T,), -1 at its end.

Each corner is an edge, from its vertex, which may go, to the next one of the triangle, which would be kept: `costs`
(3T,), infinite for one that may not collapse. A tournament among them has its `winners` (6T,): the edges themselves
from 3T on, above them the winners of each two, the cheapest of all at 1. Costs are rounded to float32, so that nearly
equal ones are equal on all machines; then the edge between lower vertices wins.
"""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Bool = npt.NDArray[np.bool_]
Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

_DATA_COST = 2e-4  # of a full change of weights along a metre [m^4]
_FLIP = 0.25  # a triangle must not rotate by more than the angle with this cosine
_TETRAHEDRON = 4  # vertices around an edge and on it; it cannot lose one
_FLAT = 1e-16  # square of the least doubled area of a triangle [m^4]


@kernel("void(f8[:,::1], i8[::1], i8[::1])")
def nearest_mirrored(points: Float64, upwards: Int64, out: Int64) -> None:
    """Write into `out` (V,) which point is nearest to the mirror image of each in the plane x = 0; `upwards` (V,): the
    points by height."""
    count = points.shape[0]
    for place in range(count):
        one = upwards[place]
        nearest, least = one, 4.0 * points[one, 0] * points[one, 0]
        for way in range(2):
            at, step = (place + 1, 1) if way == 0 else (place - 1, -1)
            while 0 <= at < count:
                other = upwards[at]
                dy, dz = points[other, 1] - points[one, 1], points[other, 2] - points[one, 2]
                if dy * dy > least:
                    break
                dx = points[other, 0] + points[one, 0]
                squared = dx * dx + dy * dy + dz * dz
                if squared < least or (squared == least and other < nearest):
                    nearest, least = other, squared
                at += step
        out[one] = nearest


@kernel("i8(i8, i8[:,::1], i8[::1], i8[::1], i8[::1])")
def neighbours(vertex: int, triangles: Int64, first: Int64, following: Int64, out: Int64) -> int:
    """Write the vertices around a vertex into `out` (V,); return how many there are."""
    count = 0
    corner = first[vertex]
    while corner >= 0:
        triangle = corner // 3
        corner = following[corner]
        if triangles[triangle, 0] < 0:
            continue
        for k in range(3):
            other = triangles[triangle, k]
            known = other == vertex
            for i in range(count):
                known = known or out[i] == other
            if not known:
                out[count] = other
                count += 1
    return count


@kernel("f8(i8, i8, f8[:,::1], f8[:,:,::1], f8[:,::1])")
def collapse_cost(gone: int, kept: int, points: Float64, quadrics: Float64, data: Float64) -> float:
    """Return the cost of collapsing `gone` onto `kept`: quadric error, and difference of vertex data."""
    x, y, z = points[kept, 0], points[kept, 1], points[kept, 2]
    shape = 0.0
    for i in range(4):
        row = (quadrics[gone, i, 0] + quadrics[kept, i, 0]) * x
        row += (quadrics[gone, i, 1] + quadrics[kept, i, 1]) * y
        row += (quadrics[gone, i, 2] + quadrics[kept, i, 2]) * z
        row += quadrics[gone, i, 3] + quadrics[kept, i, 3]
        shape += row * points[kept, i] if i < 3 else row
    apart = 0.0
    for i in range(data.shape[1]):
        apart += abs(data[gone, i] - data[kept, i])
    dx, dy, dz = points[gone, 0] - x, points[gone, 1] - y, points[gone, 2] - z
    return shape + _DATA_COST * math.sqrt(dx * dx + dy * dy + dz * dz) * (0.2 + apart)


@kernel("UniTuple(f8, 3)(f8[:,::1], i8, i8, i8)")
def doubled_area(points: Float64, a: int, b: int, c: int) -> tuple[float, float, float]:
    """Return the normal of a triangle, as long as twice its area."""
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


@kernel("b1(i8, i8, f8[:,::1], i8[:,::1], i8[::1], i8[::1], i8[:,::1])")
def may_collapse(
    gone: int, kept: int, points: Float64, triangles: Int64, first: Int64, following: Int64, around: Int64
) -> bool:
    """Return whether the mesh stays closed and no triangle flips if `gone` collapses onto `kept`; `around` (2, V) is
    scratch memory."""
    of_gone = neighbours(gone, triangles, first, following, around[0])
    of_kept = neighbours(kept, triangles, first, following, around[1])
    shared = 0
    for i in range(of_gone):
        for j in range(of_kept):
            if around[0, i] == around[1, j]:
                shared += 1
    if shared != 2 or of_gone + of_kept - shared <= _TETRAHEDRON:
        return False  # the mesh would become non-manifold, or a tetrahedron degenerate
    corner = first[gone]
    while corner >= 0:
        triangle = corner // 3
        corner = following[corner]
        a, b, c = triangles[triangle, 0], triangles[triangle, 1], triangles[triangle, 2]
        if a < 0 or kept in (a, b, c):
            continue
        x0, y0, z0 = doubled_area(points, a, b, c)
        a, b, c = kept if a == gone else a, kept if b == gone else b, kept if c == gone else c
        x1, y1, z1 = doubled_area(points, a, b, c)
        before, after = x0 * x0 + y0 * y0 + z0 * z0, x1 * x1 + y1 * y1 + z1 * z1
        if x0 * x1 + y0 * y1 + z0 * z1 < _FLIP * math.sqrt(before * after) or after < _FLAT:
            return False
    return True


@kernel("i8(i8, i8, f8[:,:,::1], i8[:,::1], i8[::1], i8[::1])")
def collapse(gone: int, kept: int, quadrics: Float64, triangles: Int64, first: Int64, following: Int64) -> int:
    """Collapse `gone` onto `kept`; return how many triangles are gone by that."""
    removed = 0
    corner, last = first[gone], first[gone]
    while corner >= 0:
        triangle = corner // 3
        a, b, c = triangles[triangle, 0], triangles[triangle, 1], triangles[triangle, 2]
        if a >= 0 and kept in (a, b, c):
            triangles[triangle, 0] = -1
            removed += 1
        elif a >= 0:
            triangles[triangle, corner % 3] = kept
        last, corner = corner, following[corner]
    following[last] = first[kept]
    first[kept] = first[gone]
    first[gone] = -1
    for i in range(4):
        for j in range(4):
            quadrics[kept, i, j] += quadrics[gone, i, j]
    return removed


@kernel("void(i8, f8, i8[:,::1], f4[::1], i8[::1])")
def set_cost(edge: int, cost: float, triangles: Int64, costs: Float32, winners: Int64) -> None:
    """Set the cost of an edge, and let the cheaper ones win on all matches from there to the top."""
    costs[edge] = cost
    node = (costs.shape[0] + edge) // 2
    while node > 0:
        one, other = winners[2 * node], winners[2 * node + 1]
        other_wins = costs[other] < costs[one]
        if costs[other] == costs[one]:
            by_gone = triangles[other // 3, other % 3] - triangles[one // 3, one % 3]
            by_kept = triangles[other // 3, (other + 1) % 3] - triangles[one // 3, (one + 1) % 3]
            other_wins = by_gone < 0 or (by_gone == 0 and by_kept < 0)
        winners[node] = other if other_wins else one
        node //= 2


@kernel("void(i8, f8[:,::1], f8[:,:,::1], f8[:,::1], i8[::1], b1[::1], i8[:,::1], i8[::1], i8[::1], f4[::1], i8[::1])")
def refresh_costs(
    vertex: int, points: Float64, quadrics: Float64, data: Float64, partner: Int64, fixed: Bool,
    triangles: Int64, first: Int64, following: Int64, costs: Float32, winners: Int64,
) -> None:  # fmt: skip
    """Compute the costs of all edges from and to a vertex."""
    corner = first[vertex]
    while corner >= 0:
        triangle = corner // 3
        for k in range(3):
            gone, kept, cost = triangles[triangle, k], triangles[triangle, (k + 1) % 3], math.inf
            if triangles[triangle, 0] >= 0:
                if gone != vertex and kept != vertex:
                    continue
                if not fixed[gone] and (partner[gone] != gone or partner[kept] == kept):  # those at x = 0 stay there
                    cost = collapse_cost(gone, kept, points, quadrics, data)
            set_cost(3 * triangle + k, cost, triangles, costs, winners)
        corner = following[corner]


@kernel("void(f8[:,::1], f8[:,:,::1], f8[:,::1], i8[::1], b1[::1], i8, i8[:,::1], i8[::1], i8[::1])")
def collapse_cheapest(
    points: Float64, quadrics: Float64, data: Float64, partner: Int64, fixed: Bool, target: int,
    triangles: Int64, first: Int64, following: Int64,
) -> None:  # fmt: skip
    """Collapse the cheapest edges until no more than `target` triangles are left, or no edge may collapse.

    `quadrics` (V, 4, 4), `data` (V, C); `partner` (V,): mirrored vertices, which collapse together; `fixed` (V,): those
    that stay. Changes quadrics, triangles and lists.
    """
    vertices, left, edges = points.shape[0], triangles.shape[0], 3 * triangles.shape[0]
    around = np.empty((2, vertices), np.int64)
    costs, winners = np.full(edges, np.float32(math.inf)), np.empty(2 * edges, np.int64)
    for node in range(2 * edges - 1, 0, -1):
        winners[node] = node - edges if node >= edges else winners[2 * node]
    for vertex in range(vertices):
        refresh_costs(vertex, points, quadrics, data, partner, fixed, triangles, first, following, costs, winners)
    while left > target:
        edge = winners[1]
        if costs[edge] == math.inf:
            return
        gone, kept = triangles[edge // 3, edge % 3], triangles[edge // 3, (edge + 1) % 3]
        sides = 1 if partner[gone] == gone else 2
        possible = partner[gone] != kept and partner[kept] != gone
        for side in range(sides):
            one, other = (gone, kept) if side == 0 else (partner[gone], partner[kept])
            possible = possible and may_collapse(one, other, points, triangles, first, following, around)
        if not possible:
            set_cost(edge, math.inf, triangles, costs, winners)  # until an edge beside it has collapsed
            continue
        for side in range(sides):
            one, other = (gone, kept) if side == 0 else (partner[gone], partner[kept])
            left -= collapse(one, other, quadrics, triangles, first, following)
        for side in range(sides):
            around[1, 0] = kept if side == 0 else partner[kept]
            count = neighbours(around[1, 0], triangles, first, following, around[0])
            around[0, count] = around[1, 0]
            for n in range(count + 1):
                vertex = around[0, n]
                refresh_costs(
                    vertex, points, quadrics, data, partner, fixed, triangles, first, following, costs, winners
                )
