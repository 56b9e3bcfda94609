"""Even spreading (T109): dancers as equal charges on a stage with a uniform opposite charge.

The thesis puts a repulsor into every over-populated cell of a grid and an attractor into every under-populated one.
Cells cannot detect an imbalance beyond their neighbours, and the grid itself shows in the result. Here the population,
smoothed by a Gaussian, minus its mean is the source of a potential (a Poisson equation on a mesh, solved exactly by
cosines, so the stage edges reflect). Its gradient moves dancers from crowded to empty places at any distance. A
repulsion between near neighbours restores the detail lost by smoothing and keeps distances even (particle-particle
particle-mesh after Hockney & Eastwood 1981).
"""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

MAX_MESH_NODES = 64
"""Largest number of mesh nodes along an axis."""
MAX_CELLS = 64
"""Largest number of neighbour cells along an axis."""
TIME_CONSTANT = 0.6
"""Time constant [s] of evening out at unlimited speed."""
SMOOTHING = 0.62
"""Width of the Gaussian as a share of the mean distance between dancers."""
REPULSION_REACH = 2.6
"""Range of the neighbour repulsion in widths of the Gaussian."""


@kernel("void(f4[:,:,:,::1])")
def fill_cosines(cosines: Float32) -> None:
    """Write cos(pi k (j + 1/2) / n) for n nodes into cosines[0, n, k, j] and, transposed, into cosines[1, n, j, k].

    cosines (2, MESH + 1, MESH, MESH).
    """
    for n in range(1, MAX_MESH_NODES + 1):
        for k in range(n):
            for j in range(n):
                cosines[0, n, k, j] = math.cos(math.pi * k * (j + 0.5) / n)
                cosines[1, n, j, k] = cosines[0, n, k, j]


@kernel("void(f4[:,::1],f4[:,::1],f4[:,::1],i8,i8,i8)")
def matrix_product(out: Float32, a: Float32, b: Float32, rows: int, inner: int, columns: int) -> None:
    """Write the matrix product of the upper left corners of `a` (rows, inner) and `b` (inner, columns) into `out`."""
    for r in range(rows):
        for c in range(columns):
            out[r, c] = 0.0
        for k in range(inner):
            weight = a[r, k]
            for c in range(columns):
                out[r, c] += weight * b[k, c]


@kernel("void(f4[:,:,::1],i8,i8,f4[:,:,:,::1],f8,f8,f8)")
def solve_poisson(mesh: Float32, nx: int, nz: int, cosines: Float32, step_x: float, step_z: float, s: float) -> None:
    """Solve for the potential whose -laplace is mesh[0] (nz, nx), with reflecting edges, smoothed by a Gaussian of `s`
    [m].

    In place: cosine transform along both axes, divide by the squared wave number, inverse transform. mesh[1] and
    mesh[2] are overwritten.
    """
    matrix_product(mesh[1], mesh[0], cosines[1, nx], nz, nx, nx)
    matrix_product(mesh[2], cosines[0, nz], mesh[1], nz, nz, nx)
    for m in range(nz):
        wz = math.pi * m / (nz * step_z)
        for k in range(nx):
            wx = math.pi * k / (nx * step_x)
            w2 = wx * wx + wz * wz
            scale = (1.0 if k == 0 else 2.0) * (1.0 if m == 0 else 2.0) / (nx * nz)
            mesh[2, m, k] *= scale * math.exp(-0.5 * s * s * w2) / w2 if w2 > 0.0 else 0.0
    matrix_product(mesh[1], mesh[2], cosines[0, nx], nz, nx, nx)
    matrix_product(mesh[0], cosines[1, nz], mesh[1], nz, nz, nx)


@kernel("UniTuple(f8,3)(f8,f8,i8)")
def bracketing_nodes(place: float, step: float, nodes: int) -> tuple[float, float, float]:
    """Return the nodes on both sides of a position (from the edge, [m]) and the fraction between them."""
    u = place / step - 0.5
    low = math.floor(u)
    return float(min(max(low, 0), nodes - 1)), float(min(max(low + 1, 0), nodes - 1)), u - low


@kernel("void(f4[:,:,::1],i8,i8,f8,f8,f8,f8,f4[:,::1],i4[::1],i8,f8)")
def deposit(
    mesh: Float32,
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
    """Distribute population minus its mean onto mesh[0] (nz, nx), bilinearly; `scale` is the amount of one dancer."""
    mean = scale * members / (nx * nz)
    for r in range(nz):
        for c in range(nx):
            mesh[0, r, c] = -mean
    for k in range(members):
        i = member[k]
        c0, c1, u = bracketing_nodes(position[i, 0] - left, step_x, nx)
        r0, r1, v = bracketing_nodes(position[i, 1] - back, step_z, nz)
        a, b, e, f = int(c0), int(c1), int(r0), int(r1)
        mesh[0, e, a] += scale * (1.0 - u) * (1.0 - v)
        mesh[0, e, b] += scale * u * (1.0 - v)
        mesh[0, f, a] += scale * (1.0 - u) * v
        mesh[0, f, b] += scale * u * v


@kernel("void(f4[:,:,::1],i8,i8,f8,f8)")
def gradient(mesh: Float32, nx: int, nz: int, step_x: float, step_z: float) -> None:
    """Write the downhill gradient of the potential mesh[0] into mesh[1] (along x) and mesh[2] (along z); zero at the
    edges.
    """
    for r in range(nz):
        above, below = max(r - 1, 0), min(r + 1, nz - 1)
        for c in range(nx):
            before, after = max(c - 1, 0), min(c + 1, nx - 1)
            mesh[1, r, c] = (mesh[0, r, before] - mesh[0, r, after]) / (2.0 * step_x)
            mesh[2, r, c] = (mesh[0, above, c] - mesh[0, below, c]) / (2.0 * step_z)


@kernel("UniTuple(f8,2)(f4[:,:,::1],i8,i8,f8,f8,f8,f8)")
def gradient_at(
    mesh: Float32, nx: int, nz: int, x: float, z: float, step_x: float, step_z: float
) -> tuple[float, float]:
    """Return the gradient at a position (from the left and back edge, [m]), bilinear; mirrored beyond the edges."""
    c0, c1, u = bracketing_nodes(x, step_x, nx)
    r0, r1, v = bracketing_nodes(z, step_z, nz)
    a, b, e, f = int(c0), int(c1), int(r0), int(r1)
    # between the outermost nodes and the edge the slope towards the edge falls to zero
    edge_x = min(max(min(x, nx * step_x - x) / (0.5 * step_x), 0.0), 1.0)
    edge_z = min(max(min(z, nz * step_z - z) / (0.5 * step_z), 0.0), 1.0)
    gx = (mesh[1, e, a] * (1.0 - u) + mesh[1, e, b] * u) * (1.0 - v) + (
        mesh[1, f, a] * (1.0 - u) + mesh[1, f, b] * u
    ) * v
    gz = (mesh[2, e, a] * (1.0 - u) + mesh[2, e, b] * u) * (1.0 - v) + (
        mesh[2, f, a] * (1.0 - u) + mesh[2, f, b] * u
    ) * v
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
    return (1.0 - t * t) * (1.0 - t * t) / max(d, 0.05)


@kernel("void(f4[:,::1],i4[::1],i8,f8[::1],f4[:,:,::1],f4[:,:,:,::1],i4[::1],i4[::1],f8[:,::1])")
def spread(
    position: Float32,
    member: Int32,
    members: int,
    area: Float64,
    mesh: Float32,
    cosines: Float32,
    start: Int32,
    order: Int32,
    wish: Float64,
) -> None:
    """Write the velocity [m/s] with which each member of a group spreads over an area into wish (A, 2) (T109).

    position (A, 2) [m]; member: the spreading agents, the first `members` count; area: left, right, back, front [m];
    mesh (3, MESH, MESH), cosines, start (CELLS² + 1,), order (A,): scratch.
    """
    left, right, back, front = area[0], area[1], area[2], area[3]
    width, depth = right - left, front - back
    spacing = math.sqrt(width * depth / max(members, 1))
    s = max(SMOOTHING * spacing, width / MAX_MESH_NODES, depth / MAX_MESH_NODES)
    nx = int(min(max(math.ceil(width / s), 2), MAX_MESH_NODES))
    nz = int(min(max(math.ceil(depth / s), 2), MAX_MESH_NODES))
    step_x, step_z = width / nx, depth / nz
    # units in which an even population is 1: the area per dancer over the area of a mesh cell
    share = width * depth / max(members, 1)
    deposit(mesh, nx, nz, left, back, step_x, step_z, position, member, members, share / (step_x * step_z))
    solve_poisson(mesh, nx, nz, cosines, step_x, step_z, s)
    gradient(mesh, nx, nz, step_x, step_z)
    reach = REPULSION_REACH * s
    columns = int(min(max(math.floor(width / reach), 1), MAX_CELLS))
    rows = int(min(max(math.floor(depth / reach), 1), MAX_CELLS))
    size_x, size_z = width / columns, depth / rows
    sort_members(position, member, members, left, back, size_x, size_z, columns, rows, start, order)
    for k in range(members):
        i = member[k]
        x, z = float(position[i, 0]), float(position[i, 1])
        gx, gz = gradient_at(
            mesh, nx, nz, min(max(x - left, 0.0), width), min(max(z - back, 0.0), depth), step_x, step_z
        )
        px, pz = 0.0, 0.0
        column, row = axis_cell(x - left, size_x, columns), axis_cell(z - back, size_z, rows)
        for r in range(max(row - 1, 0), min(row + 2, rows)):
            for c in range(max(column - 1, 0), min(column + 2, columns)):
                for n in range(start[r * columns + c], start[r * columns + c + 1]):
                    j = order[n]
                    dx, dz = x - position[j, 0], z - position[j, 1]
                    d2 = dx * dx + dz * dz
                    if d2 < reach * reach and j != i:
                        d = math.sqrt(d2)
                        f = pair_repulsion(d, reach) / max(d, 1e-6)
                        px += f * dx
                        pz += f * dz
        # the agent's mirror images: without them the outermost dancers would stand on the edge itself
        px += pair_repulsion(2.0 * max(x - left, 0.0), reach) - pair_repulsion(2.0 * max(right - x, 0.0), reach)
        pz += pair_repulsion(2.0 * max(z - back, 0.0), reach) - pair_repulsion(2.0 * max(front - z, 0.0), reach)
        near = share / (2.0 * math.pi)
        wish[i, 0] = (
            gx + near * px + min(max(left - x, 0.0), 1.0) * 2.0 - min(max(x - right, 0.0), 1.0) * 2.0
        ) / TIME_CONSTANT
        wish[i, 1] = (
            gz + near * pz + min(max(back - z, 0.0), 1.0) * 2.0 - min(max(z - front, 0.0), 1.0) * 2.0
        ) / TIME_CONSTANT
