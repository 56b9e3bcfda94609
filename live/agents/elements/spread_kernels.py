"""Even spreading (T109): dancers as equal charges on a stage with a uniform opposite charge.

The thesis puts a repulsor into every over-populated cell of a grid and an attractor into every under-populated one.
Cells cannot detect an imbalance beyond their neighbours, and the grid itself shows in the result. Here the population,
smoothed by a Gaussian, minus its mean is the source of a potential (a Poisson equation on a mesh, solved by multigrid,
whose cost grows as the number of nodes; the stage edges reflect). Its gradient moves dancers from crowded to empty
places at any distance. A repulsion between near neighbours restores the detail lost by smoothing and keeps distances
even (particle-particle particle-mesh after Hockney & Eastwood 1981).
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

NODES_PER_DANCER, SPARE_NODES = 8, 512
"""Capacity of the mesh: so many nodes for each dancer, all levels together, and some more."""
TIME_CONSTANT = 0.6
"""Time constant [s] of evening out at unlimited speed."""
SMOOTHING = 0.62
"""Width of the Gaussian as a share of the mean distance between dancers."""
REPULSION_REACH = 2.6
"""Range of the neighbour repulsion in widths of the Gaussian."""
NEAREST = 0.05
"""Distance below which the repulsion grows no more [m]."""
LANES = 8
"""Neighbours that are summed side by side."""
COARSEST = 4
"""Fewest nodes along an axis of the coarsest level."""
CYCLES = 3
"""V-cycles of the multigrid; each leaves a tenth of the error."""
DAMPING = 0.8
"""Share of a Jacobi step that smooths best in two dimensions."""
_1: Any = np.uint64(1)


@kernel("i8(i8,i8)")
def level_count(nx: int, nz: int) -> int:
    """Return how often a mesh can be halved along both axes."""
    count, size = 0, min(nx, nz)
    while size >= 2 * COARSEST:
        size //= 2
        count += 1
    return count


@kernel("void(f4[::1],f4[::1],i8,i8,f8,f8)")
def blur(field: Float32, other: Float32, nx: int, nz: int, x2: float, z2: float) -> None:
    """Smooth `field` (nz nx) by a Gaussian with the variances x2 and z2 [nodes²]; `other` is scratch.

    A binomial filter several times: its variances add up.
    """
    times = math.ceil(1.5 * max(x2, z2))
    a, b = np.float32(0.5 * x2 / max(times, 1)), np.float32(0.5 * z2 / max(times, 1))
    two: Any = np.float32(2.0)
    for _ in range(times):
        for r in range(nz):
            row: Any = np.uint64(r * nx)
            for c in range(nx):
                k = row + np.uint64(c)
                left, right = row + np.uint64(max(c - 1, 0)), row + np.uint64(min(c + 1, nx - 1))
                other[k] = field[k] + a * (field[left] + field[right] - two * field[k])
        for r in range(nz):
            row = np.uint64(r * nx)
            above: Any = np.uint64(max(r - 1, 0) * nx)
            below: Any = np.uint64(min(r + 1, nz - 1) * nx)
            for c in range(nx):
                j: Any = np.uint64(c)
                field[row + j] = other[row + j] + b * (other[above + j] + other[below + j] - two * other[row + j])


@inline_kernel
def _outflow(phi: Float32, row: Any, above: Any, below: Any, c: Any, left: Any, right: Any, kx: Any, kz: Any) -> Any:
    """Return the discrete -laplace of `phi` at node c of a row."""
    here = phi[row + c]
    return kx * (here - phi[row + left] + here - phi[row + right]) + kz * (
        here - phi[above + c] + here - phi[below + c]
    )


@kernel("void(f4[::1],f4[::1],f4[::1],i8,i8,f4,f4,f4,f4)")
def relax(
    out: Float32, phi: Float32, rhs: Float32, nx: int, nz: int, kx: float, kz: float, keep: float, step: float
) -> None:
    """Write `keep` times phi plus `step` times the residual of -laplace(phi) = rhs into `out`, (nz nx) each.

    kx, kz: 1 over the squares of the distances between nodes. Beyond the edges `phi` is mirrored.
    """
    for r in range(nz):
        row: Any = np.uint64(r * nx)
        above: Any = np.uint64(max(r - 1, 0) * nx)
        below: Any = np.uint64(min(r + 1, nz - 1) * nx)
        for c in range(1, nx - 1):
            j: Any = np.uint64(c)
            rest = rhs[row + j] - _outflow(phi, row, above, below, j, j - _1, j + _1, kx, kz)
            out[row + j] = keep * phi[row + j] + step * rest
        first: Any = np.uint64(0)
        last: Any = np.uint64(nx - 1)
        rest = rhs[row] - _outflow(phi, row, above, below, first, first, min(_1, last), kx, kz)
        out[row] = keep * phi[row] + step * rest
        rest = rhs[row + last] - _outflow(phi, row, above, below, last, max(last, _1) - _1, last, kx, kz)
        out[row + last] = keep * phi[row + last] + step * rest


@kernel("void(f4[::1],f4[::1],i8,i8,f4,f4,i8)")
def solve_coarsest(phi: Float32, rhs: Float32, nx: int, nz: int, kx: float, kz: float, rounds: int) -> None:
    """Solve -laplace(phi) = rhs on a small mesh by successive over-relaxation, in place.

    As many sweeps as there are nodes along the longer axis are a round, which leaves 1 % of the error.
    """
    size = max(nx, nz)
    over = np.float32(2.0 / (1.0 + math.sin(math.pi / (math.sqrt(2.0) * max(size, 2)))))
    for _ in range(rounds * size):
        for r in range(nz):
            row: Any = np.uint64(r * nx)
            above: Any = np.uint64(max(r - 1, 0) * nx)
            below: Any = np.uint64(min(r + 1, nz - 1) * nx)
            inner = kz * ((r > 0) + (r < nz - 1))
            for c in range(nx):
                j: Any = np.uint64(c)
                left, right = np.uint64(max(c - 1, 0)), np.uint64(min(c + 1, nx - 1))
                weight = np.float32(inner + kx * ((c > 0) + (c < nx - 1)))
                if weight > 0.0:
                    rest = rhs[row + j] - _outflow(phi, row, above, below, j, left, right, kx, kz)
                    phi[row + j] += over * rest / weight


@kernel("void(f4[::1],f4[::1],i8,i8)")
def restrict(coarse: Float32, fine: Float32, nx: int, nz: int) -> None:
    """Write the means of four nodes of `fine` into `coarse` (nz nx)."""
    quarter: Any = np.float32(0.25)
    for r in range(nz):
        row, upper, lower = np.uint64(r * nx), np.uint64(4 * r * nx), np.uint64((4 * r + 2) * nx)
        for c in range(nx):
            j: Any = np.uint64(2 * c)
            sum_ = fine[upper + j] + fine[upper + j + _1] + fine[lower + j] + fine[lower + j + _1]
            coarse[row + np.uint64(c)] = quarter * sum_


@kernel("void(f4[::1],f4[::1],i8,i8)")
def prolong(fine: Float32, coarse: Float32, nx: int, nz: int) -> None:
    """Add `coarse` (nz nx), interpolated bilinearly, to `fine`, which has twice as many nodes along both axes."""
    near: Any = np.float32(0.75)
    far: Any = np.float32(0.25)
    for r in range(2 * nz):
        home: Any = np.uint64((r // 2) * nx)
        beside: Any = np.uint64(min(max(r // 2 + (1 if r % 2 else -1), 0), nz - 1) * nx)
        row: Any = np.uint64(2 * r * nx)
        for c in range(nx):
            j: Any = np.uint64(c)
            left, right = np.uint64(max(c - 1, 0)), np.uint64(min(c + 1, nx - 1))
            middle = near * coarse[home + j] + far * coarse[beside + j]
            fine[row + j + j] += near * middle + far * (near * coarse[home + left] + far * coarse[beside + left])
            fine[row + j + j + _1] += near * middle + far * (near * coarse[home + right] + far * coarse[beside + right])


@kernel("void(f4[:,::1],i8,i8,f8,f8)")
def solve_poisson(mesh: Float32, nx: int, nz: int, step_x: float, step_z: float) -> None:
    """Solve for the potential whose -laplace is mesh[0, :nz nx], of mean 0, with reflecting edges, into mesh[1].

    Multigrid: V-cycles with two Jacobi steps on each side. The coarser levels stand behind the finest one in the rows;
    nx and nz can be halved as often as `level_count` says. mesh[2] is scratch.
    """
    levels = level_count(nx, nz)
    for node in range(nx * nz):
        mesh[1, node] = 0.0
    for _ in range(CYCLES if levels else 1):
        at, w, h = 0, nx, nz
        kx, kz = 1.0 / (step_x * step_x), 1.0 / (step_z * step_z)
        for _ in range(levels):
            to, n = at + w * h, w * h // 4
            rhs, phi, other = mesh[0, at:to], mesh[1, at:to], mesh[2, at:to]
            step = DAMPING / (2.0 * kx + 2.0 * kz)
            relax(other, phi, rhs, w, h, kx, kz, 1.0, step)
            relax(phi, other, rhs, w, h, kx, kz, 1.0, step)
            relax(other, phi, rhs, w, h, kx, kz, 0.0, 1.0)
            at, w, h, kx, kz = to, w // 2, h // 2, 0.25 * kx, 0.25 * kz
            restrict(mesh[0, to : to + n], other, w, h)
            for node in range(to, to + n):
                mesh[1, node] = 0.0
        solve_coarsest(mesh[1, at : at + w * h], mesh[0, at : at + w * h], w, h, kx, kz, 1 if levels else 3)
        for _ in range(levels):
            to, at, w, h, kx, kz = at, at - 4 * w * h, 2 * w, 2 * h, 4.0 * kx, 4.0 * kz
            rhs, phi, other = mesh[0, at:to], mesh[1, at:to], mesh[2, at:to]
            step = DAMPING / (2.0 * kx + 2.0 * kz)
            prolong(phi, mesh[1, to : to + w * h // 4], w // 2, h // 2)
            relax(other, phi, rhs, w, h, kx, kz, 1.0, step)
            relax(phi, other, rhs, w, h, kx, kz, 1.0, step)


@kernel("UniTuple(f8,3)(f8,f8,i8)")
def bracketing_nodes(place: float, step: float, nodes: int) -> tuple[float, float, float]:
    """Return the nodes on both sides of a position (from the edge, [m]) and the fraction between them."""
    u = place / step - 0.5
    low = math.floor(u)
    return float(min(max(low, 0), nodes - 1)), float(min(max(low + 1, 0), nodes - 1)), u - low


@kernel("void(f4[::1],i8,i8,f8,f8,f8,f8,f4[:,::1],i4[::1],i8,f8)")
def deposit(
    population: Float32,
    nx: int,
    nz: int,
    left: float,
    back: float,
    step_x: float,
    step_z: float,
    position: Float32,
    member: Int32,
    members: int,
    scale: float,
) -> None:
    """Distribute the members minus their mean onto `population` (nz nx), bilinearly; a dancer is `scale`."""
    mean = -scale * members / (nx * nz)
    for node in range(nz * nx):
        population[node] = mean
    for k in range(members):
        i = member[k]
        c0, c1, u = bracketing_nodes(position[i, 0] - left, step_x, nx)
        r0, r1, v = bracketing_nodes(position[i, 1] - back, step_z, nz)
        a, b, e, f = int(c0), int(c1), nx * int(r0), nx * int(r1)
        population[e + a] += scale * (1.0 - u) * (1.0 - v)
        population[e + b] += scale * u * (1.0 - v)
        population[f + a] += scale * (1.0 - u) * v
        population[f + b] += scale * u * v


@kernel("void(f4[:,::1],i8,i8,f8,f8)")
def gradient(mesh: Float32, nx: int, nz: int, step_x: float, step_z: float) -> None:
    """Write the downhill gradient of the potential mesh[1] into mesh[0] (along x) and mesh[2] (along z); zero at the
    edges.
    """
    per_x, per_z = np.float32(0.5 / step_x), np.float32(0.5 / step_z)
    for r in range(nz):
        row, above, below = r * nx, max(r - 1, 0) * nx, min(r + 1, nz - 1) * nx
        for c in range(nx):
            before, after = max(c - 1, 0), min(c + 1, nx - 1)
            mesh[0, row + c] = (mesh[1, row + before] - mesh[1, row + after]) * per_x
            mesh[2, row + c] = (mesh[1, above + c] - mesh[1, below + c]) * per_z


@kernel("UniTuple(f8,2)(f4[:,::1],i8,i8,f8,f8,f8,f8)")
def gradient_at(
    mesh: Float32, nx: int, nz: int, x: float, z: float, step_x: float, step_z: float
) -> tuple[float, float]:
    """Return the gradient at a position (from the left and back edge, [m]), bilinear; mirrored beyond the edges."""
    c0, c1, u = bracketing_nodes(x, step_x, nx)
    r0, r1, v = bracketing_nodes(z, step_z, nz)
    a, b, e, f = int(c0), int(c1), nx * int(r0), nx * int(r1)
    # between the outermost nodes and the edge the slope towards the edge falls to zero
    edge_x = min(max(min(x, nx * step_x - x) / (0.5 * step_x), 0.0), 1.0)
    edge_z = min(max(min(z, nz * step_z - z) / (0.5 * step_z), 0.0), 1.0)
    gx = (mesh[0, e + a] * (1.0 - u) + mesh[0, e + b] * u) * (1.0 - v)
    gx += (mesh[0, f + a] * (1.0 - u) + mesh[0, f + b] * u) * v
    gz = (mesh[2, e + a] * (1.0 - u) + mesh[2, e + b] * u) * (1.0 - v)
    gz += (mesh[2, f + a] * (1.0 - u) + mesh[2, f + b] * u) * v
    return gx * edge_x, gz * edge_z


@kernel("i8(f8,f8,i8)")
def axis_cell(place: float, size: float, cells: int) -> int:
    """Return the cell of a position (from the edge, [m]) along one axis, clamped to the outermost cells."""
    return int(min(max(math.floor(place / size), 0), cells - 1))


@kernel("void(f4[:,::1],i4[::1],i8,f8,f8,f8,f8,i8,i8,i4[::1],i4[::1])")
def sort_members(
    position: Float32,
    member: Int32,
    members: int,
    left: float,
    back: float,
    size_x: float,
    size_z: float,
    columns: int,
    rows: int,
    start: Int32,
    order: Int32,
) -> None:
    """Counting sort: members of cell c are order[start[c]:start[c + 1]], in index order."""
    for c in range(columns * rows + 1):
        start[c] = 0
    for k in range(members):
        i = member[k]
        row = axis_cell(position[i, 1] - back, size_z, rows)
        start[row * columns + axis_cell(position[i, 0] - left, size_x, columns) + 1] += 1
    for c in range(columns * rows):
        start[c + 1] += start[c]
    for k in range(members - 1, -1, -1):
        i = member[k]
        row = axis_cell(position[i, 1] - back, size_z, rows)
        c = row * columns + axis_cell(position[i, 0] - left, size_x, columns) + 1
        start[c] -= 1
        order[start[c]] = i
    for c in range(columns * rows):
        start[c] = start[c + 1]
    start[columns * rows] = members


@kernel("f8(f8,f8)")
def pair_repulsion(d: float, reach: float) -> float:
    """Return the repulsion of a neighbour at `d` [m]: the part of 1 / d lost by smoothing; zero from `reach` [m] on."""
    if d >= reach:
        return 0.0
    t = d / reach
    return (1.0 - t * t) * (1.0 - t * t) / max(d, NEAREST)


@inline_kernel
def add_repulsions(
    sums: Float32, xs: Float32, zs: Float32, begin: int, end: int, x: Any, z: Any, per_reach2: Any
) -> None:
    """Add the repulsions, as `pair_repulsion`, of the agents begin to end - 1 on one at (x, z) to `sums` (2, LANES).

    Each lane takes every LANES-th neighbour, without branches, so that the compiler vectorises it. The agent's own is
    zero.
    """
    one: Any = np.float32(1.0)
    zero: Any = np.float32(0.0)
    least: Any = np.float32(NEAREST * NEAREST)
    for first in range(begin, end, LANES):
        for lane in range(LANES):
            n: Any = np.uint64(first + lane)
            dx, dz = x - xs[n], z - zs[n]
            d2 = dx * dx + dz * dz
            t = max(one - d2 * per_reach2, zero)
            f = (t * t if first + lane < end else zero) / max(d2, least)
            sums[0, lane] += f * dx
            sums[1, lane] += f * dz


@kernel("UniTuple(i8,2)(f8,f8,f8,i8)")
def mesh_size(width: float, depth: float, s: float, capacity: int) -> tuple[int, int]:
    """Return how many nodes (along x and z) a mesh over an area [m] has, at most `s` [m] apart.

    They can be halved as often as `level_count` says. If that exceeds the `capacity` for all levels, as on a stage that
    is all length, they are farther apart.
    """
    while True:
        nx, nz = max(math.ceil(width / s), 2), max(math.ceil(depth / s), 2)
        unit = 1 << level_count(nx, nz)
        nx, nz = -(-nx // unit) * unit, -(-nz // unit) * unit
        if 4 * nx * nz <= 3 * capacity:
            return nx, nz
        s *= 1.25


@kernel("UniTuple(f8,4)(f8[::1],i8,i8)")
def mesh_spacing(area: Float64, members: int, capacity: int) -> tuple[float, float, float, float]:
    """Return the nodes along x and z of the mesh for so many members, the width of the Gaussian [m], and the area of
    each [m²]."""
    width, depth = area[1] - area[0], area[3] - area[2]
    share = width * depth / max(members, 1)
    nx, nz = mesh_size(width, depth, SMOOTHING * math.sqrt(share), capacity)
    return float(nx), float(nz), max(SMOOTHING * math.sqrt(share), width / nx, depth / nz), share


@kernel("void(f4[:,::1],i4[::1],i8,f8[::1],f4[:,::1],i4[::1],i4[::1])")
def fill_spread_field(
    position: Float32, member: Int32, members: int, area: Float64, mesh: Float32, start: Int32, order: Int32
) -> None:
    """Prepare the spreading of a group over an area (T109): the gradient, and its members sorted into cells.

    position (A, 2) [m]; member: the spreading agents, the first `members` count; area: left, right, back, front [m].
    Results: mesh (3, NODES_PER_DANCER A + SPARE_NODES), start as long as mesh, order (A,), for `spread`.
    """
    left, right, back, front = area[0], area[1], area[2], area[3]
    width, depth = right - left, front - back
    x_nodes, z_nodes, s, share = mesh_spacing(area, members, mesh.shape[1])
    nx, nz, reach = int(x_nodes), int(z_nodes), REPULSION_REACH * s
    step_x, step_z = width / nx, depth / nz
    # units in which an even population is 1: the area per dancer over the area of a mesh cell
    deposit(mesh[0], nx, nz, left, back, step_x, step_z, position, member, members, share / (step_x * step_z))
    blur(mesh[0], mesh[2], nx, nz, (s / step_x) ** 2, (s / step_z) ** 2)
    solve_poisson(mesh, nx, nz, step_x, step_z)
    gradient(mesh, nx, nz, step_x, step_z)
    columns, rows = max(math.floor(width / reach), 1), max(math.floor(depth / reach), 1)
    size_x, size_z = width / columns, depth / rows
    sort_members(position, member, members, left, back, size_x, size_z, columns, rows, start, order)
    xs, zs = mesh[1, : members + LANES], mesh[1, members + LANES : 2 * (members + LANES)]
    for k in range(members):  # sorted: neighbours stand together
        xs[k], zs[k] = position[order[k], 0], position[order[k], 1]


@kernel("void(i8,f8[::1],f4[:,::1],i4[::1],i4[::1],f8[:,::1],i8,i8)")
def spread(
    members: int, area: Float64, mesh: Float32, start: Int32, order: Int32, wish: Float64, begin: int, end: int
) -> None:
    """Write the velocity [m/s] with which the members `order` begin..end-1 spread over an area into wish (A, 2) (T109).

    The other arrays are as `fill_spread_field` left them.
    """
    left, right, back, front = area[0], area[1], area[2], area[3]
    width, depth = right - left, front - back
    x_nodes, z_nodes, s, share = mesh_spacing(area, members, mesh.shape[1])
    nx, nz, reach = int(x_nodes), int(z_nodes), REPULSION_REACH * s
    step_x, step_z = width / nx, depth / nz
    columns, rows = max(math.floor(width / reach), 1), max(math.floor(depth / reach), 1)
    size_x, size_z = width / columns, depth / rows
    xs, zs = mesh[1, : members + LANES], mesh[1, members + LANES : 2 * (members + LANES)]
    sums, near = np.empty((2, LANES), np.float32), share / (2.0 * math.pi)
    for k in range(begin, end):
        x, z = float(xs[k]), float(zs[k])
        gx, gz = gradient_at(
            mesh, nx, nz, min(max(x - left, 0.0), width), min(max(z - back, 0.0), depth), step_x, step_z
        )
        column, row = axis_cell(x - left, size_x, columns), axis_cell(z - back, size_z, rows)
        for lane in range(LANES):
            sums[0, lane] = sums[1, lane] = np.float32(0.0)
        for r in range(max(row - 1, 0), min(row + 2, rows)):
            begin = start[r * columns + max(column - 1, 0)]
            end = start[r * columns + min(column + 1, columns - 1) + 1]
            add_repulsions(sums, xs, zs, begin, end, xs[k], zs[k], np.float32(1.0 / (reach * reach)))
        px, pz = 0.0, 0.0
        for lane in range(LANES):
            px, pz = px + sums[0, lane], pz + sums[1, lane]
        # the agent's mirror images: without them the outermost dancers would stand on the edge itself
        px += pair_repulsion(2.0 * max(x - left, 0.0), reach) - pair_repulsion(2.0 * max(right - x, 0.0), reach)
        pz += pair_repulsion(2.0 * max(z - back, 0.0), reach) - pair_repulsion(2.0 * max(front - z, 0.0), reach)
        outside_x = min(max(left - x, 0.0), 1.0) - min(max(x - right, 0.0), 1.0)
        outside_z = min(max(back - z, 0.0), 1.0) - min(max(z - front, 0.0), 1.0)
        i = order[k]
        wish[i, 0] = (gx + near * px + 2.0 * outside_x) / TIME_CONSTANT
        wish[i, 1] = (gz + near * pz + 2.0 * outside_z) / TIME_CONSTANT
