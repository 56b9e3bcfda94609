"""The recurrence (6)-(8) of the search over a block of times."""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel, part
from live.motion.partner.lanes_kernels import LANES, SIZE, compete, enter_lanes, find_predecessors, turn_of

Float64 = npt.NDArray[np.float64]
Complex128 = npt.NDArray[np.complex128]
Int64 = npt.NDArray[np.int64]
Int32 = npt.NDArray[np.int32]


@part
def _size(z: complex) -> float:
    """|z|, which need not be careful of overflow."""
    return float(np.sqrt(z.real * z.real + z.imag * z.imag))


@part
def _lowest(score: Float64) -> Any:
    """The least of the scores (P,) and whose it is, -1 if all are infinite."""
    least, cell = np.inf, -1
    for p in range(score.shape[0]):
        if score[p] < least:
            least, cell = score[p], p
    return least, cell


@part
def _bound(
    k: float, left: int, score: float, end: Float64, product: Complex128, middle: Complex128, group: Int64,
    duration: Int64, head: Complex128, head_height: Float64,
) -> Any:  # fmt: skip
    """What any cell that begins here need pay at most, since it may follow the cell that ends with `score` at `end`."""
    bound = -np.inf
    for p in range(duration.shape[0]):
        if duration[p] > left:
            continue
        turn, away = turn_of(product[p]), 0.0
        for b in range(4):
            place = turn * head[p, b] + middle[group[p]]
            dz, dx, dy = place.real - end[3 * b], place.imag - end[3 * b + 1], head_height[p, b] - end[3 * b + 2]
            away += dz * dz + dx * dx + dy * dy
        bound = max(bound, score + k * away)
    return bound


@part
def _store(out: Float64, turn: complex, middle: complex, floor: Complex128, height: Float64) -> None:
    """A sample (4,) of a target in the world: z, x, height of each point in turn."""
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
    toll: Float64,
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
    """The boundaries `begin` to `begin` + U - 1: cells that end there go on to all that begin there (8).

    toll (last + 1,): what a boundary costs at each time [m²]. product (U, P): conj(a) · x of the centred clouds of
    the cells that begin at each of the U boundaries; height_product (U, P) likewise; input_size (U, G) and
    input_middle (U, G) of the input's windows of each duration; group, duration, size, head, tail as in Stretches.
    Ways begin at boundary 0 to free_start and end at last - free_end to last. Of the cells that end at a boundary
    only those below the least + `beam` go on. ring_score (R, P) and ring_tail (R, P, 12) hold what ends at the next
    R > max(duration) boundaries; back (last + 1, P) receives the cell before each; best_end (1,), best_cell (2,): the
    best end so far and its boundary and cell. What is left out besides cannot change the result: predecessors whose
    score alone is above what others reach.
    """
    cells, ring = duration.shape[0], ring_score.shape[0]
    rows = np.empty(cells, np.int64)
    columns = np.empty((SIZE, LANES))
    least, whole = np.empty(LANES), np.empty(LANES)
    chosen = np.empty(LANES, np.int64)
    turns = np.empty(LANES, np.complex128)
    scaled = np.empty((cells, SIZE + 2))
    for row in range(min(product.shape[0], last + 1 - begin)):
        at = begin + row
        slot = at % ring
        lowest, cell = _lowest(ring_score[slot])
        if at >= last - free_end and lowest < best_end[0]:
            best_end[0], best_cell[0], best_cell[1] = lowest, at, cell
        starts = at <= free_start
        if (cell < 0 and not starts) or not np.isfinite(toll[at]):
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
            enter_lanes(
                first,
                starts,
                k,
                toll[at],
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
            compete(count, scaled, columns, whole, least, chosen)
            for i in range(min(LANES, cells - first)):
                p = first + i
                end, z, middle = at + duration[p], product[row, p], input_middle[row, group[p]]
                if end > last or not np.isfinite(least[i]):
                    continue
                distance = input_size[row, group[p]] + size[p] - 2.0 * (_size(z) + height_product[row, p])
                ring_score[end % ring, p] = least[i] + whole[i] + distance + toll[end]
                back[end, p] = -1 if starts else rows[chosen[i]]
                _store(ring_tail[end % ring, p], turns[i], middle, tail[p], tail_height[p])
        for p in range(cells):
            ring_score[slot, p] = np.inf
