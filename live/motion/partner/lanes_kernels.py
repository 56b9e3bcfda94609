"""Cells side by side: the predecessors of one boundary, and for each of LANES cells the best of them."""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import part

Float64 = npt.NDArray[np.float64]
Complex128 = npt.NDArray[np.complex128]
Int64 = npt.NDArray[np.int64]

SIZE: Any = 12
"""Coordinates of a target's sample: four points."""
LANES: Any = 16
"""Cells that are worked on side by side."""
CHECKED: Any = 8
"""After so many predecessors it is looked whether any that are left can still be better."""


@part
def turn_of(z: complex) -> Any:
    """The unit number along z, 1 for none."""
    norm = np.sqrt(z.real * z.real + z.imag * z.imag)
    return complex(z.real / norm, z.imag / norm) if norm > 1e-12 else complex(1.0, 0.0)


@part
def find_predecessors(
    k: float, bound: float, cell: int, score: Float64, tail: Float64, rows: Int64, scaled: Float64
) -> int:
    """The cells within `bound`, and `cell`, in the order of their scores, into rows (P,); what distances from their
    ends need into scaled (P, 14); how many."""
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
        for j in range(SIZE):
            e = tail[r, j]
            square += e * e
            scaled[n, j] = 2.0 * k * e
        scaled[n, SIZE] = score[r] + k * square
        scaled[n, SIZE + 1] = score[r]
    return count


@part
def enter_lanes(
    first: int, starts: bool, k: float, toll: float, product: Complex128, middle: Complex128, group: Int64,
    head: Complex128, head_height: Float64, columns: Float64, whole: Float64, least: Float64, turns: Complex128,
) -> None:  # fmt: skip
    """The cells from `first` on into the lanes: where they begin, columns (12, LANES), and k times its square."""
    for i in range(LANES):
        p, square = min(first + i, product.shape[0] - 1), 0.0
        turn = turn_of(product[p])
        turns[i] = turn
        for b in range(4):
            place = turn * head[p, b] + middle[group[p]]
            columns[3 * b, i], columns[3 * b + 1, i], columns[3 * b + 2, i] = place.real, place.imag, head_height[p, b]
        for j in range(SIZE):
            square += columns[j, i] * columns[j, i]
        whole[i] = 0.0 if starts else k * square
        least[i] = toll if starts else np.inf


@part
def compete(count: int, scaled: Float64, columns: Float64, whole: Float64, least: Float64, chosen: Int64) -> None:
    """For each lane the best of `count` predecessors: least (LANES,) less `whole`, and its number in chosen."""
    for n in range(count):
        if n % CHECKED == 0 and n > 0:
            top = -np.inf
            for i in range(LANES):
                top = max(top, least[i] + whole[i])
            if scaled[n, SIZE + 1] >= top:
                break
        e0, e1, e2, e3 = scaled[n, 0], scaled[n, 1], scaled[n, 2], scaled[n, 3]
        e4, e5, e6, e7 = scaled[n, 4], scaled[n, 5], scaled[n, 6], scaled[n, 7]
        e8, e9, e10, e11 = scaled[n, 8], scaled[n, 9], scaled[n, 10], scaled[n, 11]
        z0 = scaled[n, SIZE]
        for i in range(LANES):
            along = e0 * columns[0, i] + e1 * columns[1, i] + e2 * columns[2, i] + e3 * columns[3, i]
            along += e4 * columns[4, i] + e5 * columns[5, i] + e6 * columns[6, i] + e7 * columns[7, i]
            along += e8 * columns[8, i] + e9 * columns[9, i] + e10 * columns[10, i] + e11 * columns[11, i]
            score = z0 - along
            better = score < least[i]
            least[i] = score if better else least[i]
            chosen[i] = n if better else chosen[i]
