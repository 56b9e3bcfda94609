"""Kernels of the search: products of input windows and cells (K003), and the recurrence (6)-(8).

The recurrence finds the best predecessor for LANES cells at a time, for SIMD.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel

Float64 = npt.NDArray[np.float64]
Complex128 = npt.NDArray[np.complex128]

BLOCK_CELLS: Any = 32
"""Cells that are multiplied in one SIMD block."""


@kernel(
    "void(c16[:,::1],f8[:,::1],i8,f8[:,::1],f8[:,::1],f8[:,::1],i8,c16[:,::1],f8[:,::1])",
    fastmath={"reassoc", "contract", "nsz"},
)
def multiply(
    floor: Complex128,
    height: Float64,
    frames: int,
    real: Float64,
    imaginary: Float64,
    heights: Float64,
    first: int,
    product: Complex128,
    height_product: Float64,
) -> None:
    """Multiply windows of `frames` samples of an input with all cells of that length, for U windows one sample apart.

    floor (F, C) and height (F, C) hold the input from the first window on. real, imaginary and heights (frames C,
    cells) hold the cells. product (U, P) and height_product (U, P) receive the columns from `first` on.
    """
    points, cells = floor.shape[1], real.shape[1]
    re0, im0, up0 = np.empty(BLOCK_CELLS), np.empty(BLOCK_CELLS), np.empty(BLOCK_CELLS)
    re1, im1, up1 = np.empty(BLOCK_CELLS), np.empty(BLOCK_CELLS), np.empty(BLOCK_CELLS)
    a, b, h = np.empty(BLOCK_CELLS), np.empty(BLOCK_CELLS), np.empty(BLOCK_CELLS)
    count = product.shape[0]
    for low in range(0, cells, BLOCK_CELLS):
        width = min(BLOCK_CELLS, cells - low)
        for u in range(0, count, 2):
            other = min(u + 1, count - 1)
            re0[:], im0[:], up0[:], re1[:], im1[:], up1[:] = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for n in range(frames * points):
                f, p = n // points, n % points
                z0, z1 = floor[u + f, p], floor[other + f, p]
                y0, y1 = height[u + f, p], height[other + f, p]
                for c in range(width):
                    a[c], b[c], h[c] = real[n, low + c], imaginary[n, low + c], heights[n, low + c]
                for c in range(BLOCK_CELLS):
                    re0[c] += a[c] * z0.real - b[c] * z0.imag
                    im0[c] += a[c] * z0.imag + b[c] * z0.real
                    up0[c] += h[c] * y0
                    re1[c] += a[c] * z1.real - b[c] * z1.imag
                    im1[c] += a[c] * z1.imag + b[c] * z1.real
                    up1[c] += h[c] * y1
            for c in range(width):
                product[u, first + low + c] = complex(re0[c], im0[c])
                product[other, first + low + c] = complex(re1[c], im1[c])
                height_product[u, first + low + c] = up0[c]
                height_product[other, first + low + c] = up1[c]


Int64 = npt.NDArray[np.int64]

SAMPLE_SIZE: Any = 12
"""Number of coordinates of a target's sample: four points."""
LANES: Any = 16
"""Cells that are processed in one SIMD block."""
CHECK_INTERVAL: Any = 8
"""Number of predecessors between two checks whether the remaining ones can still be better."""


@inline_kernel
def unit_complex(z: complex) -> Any:
    """Return z normalized to length 1, or 1 where z is 0."""
    norm = np.sqrt(z.real * z.real + z.imag * z.imag)
    return complex(z.real / norm, z.imag / norm) if norm > 1e-12 else complex(1.0, 0.0)


@inline_kernel
def find_predecessors(
    k: float, bound: float, cell: int, score: Float64, tail: Float64, rows: Int64, scaled: Float64
) -> int:
    """Write the cells with scores up to `bound`, and `cell`, to rows (P,) in the order of their scores.

    scaled (P, 14) receives the terms of the distances from their ends. Return the number of cells.
    """
    waiting = np.empty(score.shape[0])
    found = np.empty(score.shape[0], np.int64)
    count = 0
    for p in range(score.shape[0]):
        if score[p] <= bound or p == cell:
            waiting[count] = score[p]
            found[count] = p
            count += 1
    order = np.argsort(waiting[:count])
    for n in range(count):
        r = found[order[n]]
        rows[n] = r
        square = 0.0
        for j in range(SAMPLE_SIZE):
            e = tail[r, j]
            square += e * e
            scaled[n, j] = 2.0 * k * e
        scaled[n, SAMPLE_SIZE] = score[r] + k * square
        scaled[n, SAMPLE_SIZE + 1] = score[r]
    return count


@inline_kernel
def load_lanes(
    first: int, starts: bool, k: float, boundary_cost: float, product: Complex128, middle: Complex128, group: Int64,
    head: Complex128, head_height: Float64, columns: Float64, squares: Float64, least: Float64, turns: Complex128,
) -> None:  # fmt: skip
    """Load the cells from `first` on into the lanes: first samples, columns (12, LANES), and k times their squares."""
    for i in range(LANES):
        p, square = min(first + i, product.shape[0] - 1), 0.0
        turn = unit_complex(product[p])
        turns[i] = turn
        for b in range(4):
            place = turn * head[p, b] + middle[group[p]]
            columns[3 * b, i], columns[3 * b + 1, i], columns[3 * b + 2, i] = place.real, place.imag, head_height[p, b]
        for j in range(SAMPLE_SIZE):
            square += columns[j, i] * columns[j, i]
        squares[i] = 0.0 if starts else k * square
        least[i] = boundary_cost if starts else np.inf


@inline_kernel
def find_best_predecessors(
    count: int, scaled: Float64, columns: Float64, squares: Float64, least: Float64, chosen: Int64
) -> None:
    """Find the best of `count` predecessors per lane: least (LANES,) is its score minus `squares`, chosen its row."""
    for n in range(count):
        if n % CHECK_INTERVAL == 0 and n > 0:
            top = -np.inf
            for i in range(LANES):
                top = max(top, least[i] + squares[i])
            if scaled[n, SAMPLE_SIZE + 1] >= top:
                break
        e0, e1, e2, e3 = scaled[n, 0], scaled[n, 1], scaled[n, 2], scaled[n, 3]
        e4, e5, e6, e7 = scaled[n, 4], scaled[n, 5], scaled[n, 6], scaled[n, 7]
        e8, e9, e10, e11 = scaled[n, 8], scaled[n, 9], scaled[n, 10], scaled[n, 11]
        z0 = scaled[n, SAMPLE_SIZE]
        for i in range(LANES):
            along = e0 * columns[0, i] + e1 * columns[1, i] + e2 * columns[2, i] + e3 * columns[3, i]
            along += e4 * columns[4, i] + e5 * columns[5, i] + e6 * columns[6, i] + e7 * columns[7, i]
            along += e8 * columns[8, i] + e9 * columns[9, i] + e10 * columns[10, i] + e11 * columns[11, i]
            score = z0 - along
            better = score < least[i]
            least[i] = score if better else least[i]
            chosen[i] = n if better else chosen[i]


Int32 = npt.NDArray[np.int32]


@inline_kernel
def _magnitude(z: complex) -> float:
    """Return |z| without protection against overflow."""
    return float(np.sqrt(z.real * z.real + z.imag * z.imag))


@inline_kernel
def _lowest(score: Float64) -> Any:
    """Return the least of the scores (P,) and its cell, -1 if all are infinite."""
    least, cell = np.inf, -1
    for p in range(score.shape[0]):
        if score[p] < least:
            least, cell = score[p], p
    return least, cell


@inline_kernel
def _bound(
    k: float, left: int, score: float, end: Float64, product: Complex128, middle: Complex128, group: Int64,
    duration: Int64, head: Complex128, head_height: Float64,
) -> Any:  # fmt: skip
    """Return an upper bound of the cost of any cell that begins here, from a predecessor with `score` and `end`."""
    bound = -np.inf
    for p in range(duration.shape[0]):
        if duration[p] > left:
            continue
        turn, away = unit_complex(product[p]), 0.0
        for b in range(4):
            place = turn * head[p, b] + middle[group[p]]
            dz, dx, dy = place.real - end[3 * b], place.imag - end[3 * b + 1], head_height[p, b] - end[3 * b + 2]
            away += dz * dz + dx * dx + dy * dy
        bound = max(bound, score + k * away)
    return bound


@inline_kernel
def _store(out: Float64, turn: complex, middle: complex, floor: Complex128, height: Float64) -> None:
    """Write a sample (4,) of a target in the world to `out`: z, x, height of each point in turn."""
    for b in range(4):
        place = turn * floor[b] + middle
        out[3 * b], out[3 * b + 1], out[3 * b + 2] = place.real, place.imag, height[b]


@kernel(
    "void(i8,i8,i8,i8,f8,f8,f8[::1],c16[:,::1],f8[:,::1],f8[:,::1],c16[:,::1],i8[::1],i8[::1],f8[::1],"
    "c16[:,::1],f8[:,::1],c16[:,::1],f8[:,::1],f8[:,::1],f8[:,:,::1],i4[:,::1],f8[::1],i8[::1])",
    fastmath={"reassoc", "contract", "nsz"},
)
def propagate(
    begin: int,
    last: int,
    free_start: int,
    free_end: int,
    k: float,
    beam: float,
    boundary_cost: Float64,
    product: Complex128,
    height_product: Float64,
    input_size: Float64,
    input_middle: Complex128,
    group: Int64,
    duration: Int64,
    size: Float64,
    head: Complex128,
    head_height: Float64,
    tail: Complex128,
    tail_height: Float64,
    ring_score: Float64,
    ring_tail: Float64,
    back: Int32,
    best_end: Float64,
    best_cell: Int64,
) -> None:
    """Propagate scores over the boundaries `begin` to `begin` + U - 1, from cells that end to cells that begin (8).

    toll (last + 1,) is the cost of a boundary at each time [m²]. product (U, P) is conj(a) · x of the centred clouds
    of the cells that begin at each of the U boundaries, height_product (U, P) the same for heights. input_size (U, G)
    and input_middle (U, G) belong to the input's windows of each duration. group, duration, size, head, tail are as in
    Stretches. Paths begin at boundaries 0 to free_start and end at last - free_end to last. Of the cells that end at a
    boundary only those below the least score + `beam` continue. ring_score (R, P) and ring_tail (R, P, 12) hold the
    cells that end at the next R > max(duration) boundaries. back (last + 1, P) receives the predecessor of each cell.
    best_end (1,) and best_cell (2,) hold the best end so far, and its boundary and cell. Other pruning is exact: it
    skips only predecessors whose score alone exceeds the total of others.
    """
    cells, ring = duration.shape[0], ring_score.shape[0]
    rows = np.empty(cells, np.int64)
    columns = np.empty((SAMPLE_SIZE, LANES))
    least, whole = np.empty(LANES), np.empty(LANES)
    chosen = np.empty(LANES, np.int64)
    turns = np.empty(LANES, np.complex128)
    scaled = np.empty((cells, SAMPLE_SIZE + 2))
    for row in range(min(product.shape[0], last + 1 - begin)):
        at = begin + row
        slot = at % ring
        lowest, cell = _lowest(ring_score[slot])
        if at >= last - free_end and lowest < best_end[0]:
            best_end[0], best_cell[0], best_cell[1] = lowest, at, cell
        starts = at <= free_start
        if (cell < 0 and not starts) or not np.isfinite(boundary_cost[at]):
            for p in range(cells):
                ring_score[slot, p] = np.inf
            continue
        count = 0
        if not starts:
            bound = _bound(
                k, last - at, lowest, ring_tail[slot, cell], product[row], input_middle[row], group, duration, head,
                head_height,
            )  # fmt: skip
            bound = min(bound, lowest + beam)
            count = find_predecessors(k, bound, cell, ring_score[slot], ring_tail[slot], rows, scaled)
        for first in range(0, cells, LANES):
            load_lanes(
                first,
                starts,
                k,
                boundary_cost[at],
                product[row],
                input_middle[row],
                group,
                head,
                head_height,
                columns,
                whole,
                least,
                turns,
            )
            chosen[:] = -1
            find_best_predecessors(count, scaled, columns, whole, least, chosen)
            for i in range(min(LANES, cells - first)):
                p = first + i
                end, z, middle = at + duration[p], product[row, p], input_middle[row, group[p]]
                if end > last or not np.isfinite(least[i]):
                    continue
                distance = input_size[row, group[p]] + size[p] - 2.0 * (_magnitude(z) + height_product[row, p])
                ring_score[end % ring, p] = least[i] + whole[i] + distance + boundary_cost[end]
                back[end, p] = -1 if starts else rows[chosen[i]]
                _store(ring_tail[end % ring, p], turns[i], middle, tail[p], tail_height[p])
        for p in range(cells):
            ring_score[slot, p] = np.inf
