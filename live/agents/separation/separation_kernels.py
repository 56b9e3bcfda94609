"""Kernels of separation: spatial cells, and pairs that are too near."""

import math

import numpy as np
import numpy.typing as npt

from live.agents.steering_kernels import hash_unit
from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

NEIGHBOUR_RANGE = 2.5
"""Cell size for neighbour search [m]: no gap is wider."""


@kernel("i8(f8,f8,f8,f8,f8,i8,i8)")
def cell_of(x: float, z: float, half_width: float, half_depth: float, size: float, columns: int, rows: int) -> int:
    """Return the index of the cell that contains (x, z); places off the stage belong to the nearest cell."""
    column = min(max(math.floor((x + half_width) / size), 0), columns - 1)
    row = min(max(math.floor((z + half_depth) / size), 0), rows - 1)
    return row * columns + column


@kernel("i8(f8,f8)")
def cell_count(extent: float, size: float) -> int:
    """Return how many cells of about `size` [m] cover `extent` [m]: at least one."""
    return max(1, math.ceil(extent / size - 1e-9))


@kernel("void(f4[:,::1], f8, f8, f8, i4[::1], i4[::1])")
def sort_into_cells(
    position: Float32, half_width: float, half_depth: float, size: float, cell_start: Int32, order: Int32
) -> None:
    """Counting sort: agents of cell c are order[cell_start[c]:cell_start[c + 1]], in numerical order."""
    columns, rows = cell_count(2.0 * half_width, size), cell_count(2.0 * half_depth, size)
    cells = columns * rows
    for c in range(cells + 1):
        cell_start[c] = 0
    for i in range(position.shape[0]):
        cell_start[cell_of(position[i, 0], position[i, 1], half_width, half_depth, size, columns, rows) + 1] += 1
    for c in range(cells):
        cell_start[c + 1] += cell_start[c]
    for i in range(position.shape[0] - 1, -1, -1):
        c = cell_of(position[i, 0], position[i, 1], half_width, half_depth, size, columns, rows)
        # fill each cell from its end; afterwards the starts are back at their values
        cell_start[c + 1] -= 1
        order[cell_start[c + 1]] = i
    for c in range(cells):
        cell_start[c] = cell_start[c + 1]
    cell_start[cells] = position.shape[0]


@kernel("void(f4[:,::1],f4[:,::1],i8,f8,f8,f8)")
def _move_within(position: Float32, anchor: Float32, i: int, dx: float, dz: float, most: float) -> None:
    """Move agent i by (dx, dz) [m], then back towards its anchor until it is at most `most` [m] away from it."""
    x, z = position[i, 0] + dx - anchor[i, 0], position[i, 1] + dz - anchor[i, 1]
    d = math.sqrt(x * x + z * z)
    scale = most / d if d > most else 1.0
    position[i, 0], position[i, 1] = anchor[i, 0] + x * scale, anchor[i, 1] + z * scale


@kernel("void(f4[:,::1],f4[:,::1],f8,f8,f8,f8,i8,i8,i4[::1],i4[::1])")
def separate_positions(
    position: Float32,
    anchor: Float32,
    gap: float,
    max_distance: float,
    half_width: float,
    half_depth: float,
    rounds: int,
    seed: int,
    cell_start: Int32,
    order: Int32,
) -> None:
    """Move `position` (A, 2) apart in place until neighbours are `gap` [m] apart, as far as `max_distance` [m] allows.

    Each stays within `max_distance` of its `anchor` (A, 2). Each of the `rounds` processes the pairs in numerical order
    and splits the missing distance between the two.
    """
    columns, rows = cell_count(2.0 * half_width, NEIGHBOUR_RANGE), cell_count(2.0 * half_depth, NEIGHBOUR_RANGE)
    for _ in range(rounds):
        sort_into_cells(position, half_width, half_depth, NEIGHBOUR_RANGE, cell_start, order)
        for i in range(position.shape[0]):
            home = cell_of(position[i, 0], position[i, 1], half_width, half_depth, NEIGHBOUR_RANGE, columns, rows)
            for row in range(max(home // columns - 1, 0), min(home // columns + 2, rows)):
                for column in range(max(home % columns - 1, 0), min(home % columns + 2, columns)):
                    c = row * columns + column
                    for k in range(cell_start[c], cell_start[c + 1]):
                        j = order[k]
                        if j <= i:
                            continue
                        dx, dz = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
                        d = math.sqrt(dx * dx + dz * dz)
                        if d >= gap:
                            continue
                        if d < 1e-5:
                            angle = 2.0 * math.pi * hash_unit(seed, i, j)
                            dx, dz, d = math.sin(angle), math.cos(angle), 1.0
                            share = 0.5 * gap
                        else:
                            share = 0.5 * (gap - d)
                        _move_within(position, anchor, i, -dx / d * share, -dz / d * share, max_distance)
                        _move_within(position, anchor, j, dx / d * share, dz / d * share, max_distance)


@kernel("void(f4[:,::1],f4[:,::1],f4[:,::1],f4[:,::1],f4[::1])")
def tether_agents(position: Float32, velocity: Float32, dancer: Float32, pace: Float32, max_distance: Float32) -> None:
    """Keep each agent within `max_distance` (A,) [m] of its dancer: at that distance the dancer drags it along.

    `position`, `velocity` (A, 2) [m, m/s] of the agents are changed in place; `dancer` (A, 2) [m] are the dancers'
    places on the path of their measure, `pace` (A, 2) [m/s] its velocity.
    """
    for n in range(position.shape[0]):
        dx, dz = position[n, 0] - dancer[n, 0], position[n, 1] - dancer[n, 1]
        d = math.sqrt(dx * dx + dz * dz)
        if d <= max_distance[n]:
            continue
        dx, dz = dx / d, dz / d
        position[n, 0], position[n, 1] = dancer[n, 0] + max_distance[n] * dx, dancer[n, 1] + max_distance[n] * dz
        out = max((velocity[n, 0] - pace[n, 0]) * dx + (velocity[n, 1] - pace[n, 1]) * dz, 0.0)
        velocity[n, 0] -= out * dx
        velocity[n, 1] -= out * dz
