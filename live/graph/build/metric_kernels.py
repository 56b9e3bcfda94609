"""Kernels of the metric: exact distances of pairs, the pairs of a block that may become edges, and their choice."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.graph.build.blend_kernels import is_blendable

Bool = npt.NDArray[np.bool_]
Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]
UInt8 = npt.NDArray[np.uint8]
Complex64 = npt.NDArray[np.complex64]
Complex128 = npt.NDArray[np.complex128]

_TWO: Any = np.float32(2.0)
_LISTED = 64
"""Most candidates of a variation that are listed in order of their lower bounds."""


@kernel("Tuple((c16,f8))(c16[::1],f8[::1],c16[::1],f8[::1])", fastmath={"reassoc", "contract"})
def pair_product(floor_a: Complex128, height_a: Float64, floor_b: Complex128, height_b: Float64) -> Any:
    """Return conj(a) · b and y_a · y_b of two clouds of P points, each (P,)."""
    re0, re1, im0, im1, y0 = 0.0, 0.0, 0.0, 0.0, 0.0
    for p in range(floor_a.shape[0]):
        a, b = floor_a[p], floor_b[p]  # sums in any order, to allow SIMD
        re0 += a.real * b.real
        re1 += a.imag * b.imag
        im0 += a.real * b.imag
        im1 += a.imag * b.real
        y0 += height_a[p] * height_b[p]
    return complex(re0 + re1, im0 - im1), y0


@kernel("i8(f8[::1], i8, f8)")
def insert_ranked(ranked: Float64, count: int, value: float) -> int:
    """Insert `value` into the `count` smallest numbers `ranked` (K,), ascending; returns their number, at most K."""
    if count == ranked.shape[0]:
        if count == 0 or value >= ranked[count - 1]:
            return count
        count -= 1
    at = count
    while at > 0 and ranked[at - 1] > value:
        ranked[at] = ranked[at - 1]
        at -= 1
    ranked[at] = value
    return count + 1


@kernel(
    "UniTuple(i8,2)(i8,c8[:,::1],f4[:,::1],f4[::1],f4[::1],f8,f8,i4[:,::1],i4[:,::1],i4[::1],i4[::1],i4[::1],i8,"
    "c16[:,::1],f8[:,::1],f8[::1],c16[:,::1],f8[:,::1],f8[::1],f4[:,:,:,::1],f4[:,:,:,::1],f8[::1],u1[:,:,::1],u1[:,:,::1],f8,f8,"
    "f8[:,::1],i4[::1],f8[:,::1],f8[::1],i4[::1],i4[::1],f8[::1],c16[::1])"
)
def nearest_in_block(  # noqa: C901 - one pass over a row
    row: int, product: Complex64, height: Float32, coarse_a: Float32, coarse_b: Float32, threshold: float,
    tolerance: float, codes_a: Int32, codes_b: Int32, variation: Int32, apart_a: Int32, apart_b: Int32, per_node: int,
    floor_a: Complex128, height_a: Float64, size_a: Float64, floor_b: Complex128, height_b: Float64, size_b: Float64,
    end: Float32, start: Float32, blend: Float64, end_stands: UInt8, start_stands: UInt8,
    min_root_cosine: float, min_chord: float,
    ranked: Float64, ranked_count: Int32, into: Float64, into_worst: Float64,
    out_row: Int32, out_column: Int32, out_distance: Float64, out_product: Complex128,
) -> tuple[int, int]:  # fmt: skip
    """Find all pairs of a block that the rule of `keep_nearest` may choose, from `row` on; some others are among them.

    product (B, M) and height (B, M), overwritten, are products of coarse clouds with sizes coarse_a (B,), coarse_b (M,)
    as in FlatClouds: lower bounds of the squared distance (K003), but for an error of `tolerance` · sizes. Pairs beyond
    the `threshold` [m] are left out, and those whose `codes` (B, 2), (M, 2) disagree: end and begin pose (agree if
    equal, or either -1), and what may not be repeated (refused if equal, and not negative); and those whose `apart_a`
    (B,) and `apart_b` (M,) are equal and not negative.

    Exact distances are computed from floor, height and size of the clouds, and only where a pair may be among the
    `per_node` edges of its row, of each `variation` (M,) the K nearest that `ranked` (V, K) holds, or among the nearest
    into its column: `into` (M, I) holds these over all blocks, infinite at first, and `into_worst` (M,) the farthest of
    them, below 0 if there are to be none. `end` (B, T, J, 4), `start` (M, T, J, 4), `blend` (T,), `end_stands`
    (B, T, 2), `start_stands` (M, T, 2) and limits: see `is_blendable`; with T = 0 every pair can be blended.

    Pairs go to the out arrays, with distance [m] and product; returns the first row that is not done because they are
    full (they must hold M), and the number of pairs.
    """
    columns = product.shape[1]
    limit = threshold * threshold
    most = ranked.shape[1]
    found = 0
    lower, computed = np.empty(columns), np.full(columns, -1, np.int64)
    touched, sizes = np.empty(columns, np.int32), np.zeros(ranked.shape[0], np.int32)
    listed = min(most, _LISTED)
    nearest, nearest_column = np.empty((ranked.shape[0], listed)), np.empty((ranked.shape[0], listed), np.int32)
    first, bound = np.empty(ranked.shape[0] * listed, np.int32), np.empty(ranked.shape[0])
    for i in range(row, product.shape[0]):
        if found + columns > out_row.shape[0]:
            return i, found
        a = coarse_a[i]
        for j in range(columns):
            z = product[i, j]
            height[i, j] = a + coarse_b[j] - _TWO * (np.sqrt(z.real * z.real + z.imag * z.imag) + height[i, j])
        for j in range(columns):
            lower[j] = height[i, j] - tolerance * (a + coarse_b[j])
        leaves, once, apart = codes_a[i, 0], codes_a[i, 1], apart_a[i]
        before = found
        groups = 0
        for j in range(columns):
            if lower[j] > limit:
                continue
            if (leaves >= 0 and codes_b[j, 0] >= 0 and leaves != codes_b[j, 0]) or (
                (once >= 0 and once == codes_b[j, 1]) or (apart >= 0 and apart == apart_b[j])
            ):
                lower[j] = math.inf
                continue
            v = variation[j]
            if sizes[v] == 0:
                touched[groups] = v
                groups += 1
            n = min(sizes[v], listed)
            sizes[v] += 1
            if n == listed:
                if lower[j] >= nearest[v, n - 1]:
                    continue
                n -= 1
            while n > 0 and nearest[v, n - 1] > lower[j]:
                nearest[v, n], nearest_column[v, n] = nearest[v, n - 1], nearest_column[v, n - 1]
                n -= 1
            nearest[v, n], nearest_column[v, n] = lower[j], j
        # as many ranks of each variation as fill the node's edges; more where too few of them can be blended
        ranks = 1
        while ranks < most:
            total = 0
            for n in range(groups):
                total += min(sizes[touched[n]], ranks)
            if total >= per_node:
                break
            ranks += 1
        count = 0
        for n in range(groups):
            v = touched[n]
            for k in range(min(sizes[v], listed, ranks)):
                first[count] = nearest_column[v, k]
                count += 1
            ranked_count[v] = 0
            bound[v] = math.inf
        while True:
            # first what is nearest by the lower bounds, then all that may be nearer than these are
            for n in range(count + columns):
                j = first[n] if n < count else n - count
                if lower[j] > limit:
                    continue
                v = variation[j]
                if (lower[j] >= bound[v] and lower[j] > into_worst[j]) or computed[j] == i:
                    continue
                computed[j] = i
                dot, level = pair_product(floor_a[i], height_a[i], floor_b[j], height_b[j])
                squared = max(size_a[i] + size_b[j] - 2.0 * abs(dot) - 2.0 * level, 0.0)
                if math.sqrt(squared) > threshold:
                    continue
                yaw = math.atan2(dot.imag, dot.real)
                if blend.shape[0] > 0 and not is_blendable(
                    end[i], start[j], yaw, blend, end_stands[i], start_stands[j], min_root_cosine, min_chord
                ):
                    continue
                ranked_count[v] = insert_ranked(ranked[v], ranked_count[v], squared)
                if ranked_count[v] >= ranks:
                    bound[v] = ranked[v, ranks - 1]
                out_row[found], out_column[found] = i, j
                out_distance[found], out_product[found] = math.sqrt(squared), dot
                found += 1
            total = 0
            for n in range(groups):
                total += min(ranked_count[touched[n]], ranks)
            if total >= per_node or ranks >= most:
                break
            ranks, count = min(most, 2 * ranks), 0
            for n in range(groups):
                v = touched[n]
                bound[v] = ranked[v, ranks - 1] if ranked_count[v] >= ranks else math.inf
        for n in range(groups):
            sizes[touched[n]] = 0
        for n in range(before, found):
            j = out_column[n]
            if into.shape[1] > 0:
                insert_ranked(into[j], into.shape[1], out_distance[n] ** 2)
                into_worst[j] = into[j, into.shape[1] - 1]
    return product.shape[0], found


@kernel("void(i8[::1],i4[::1],f8[::1],i8[::1],i4[::1],i4[::1],i8,i8,i8,b1[::1])")
def keep_nearest(  # noqa: C901
    first: Int64, column: Int32, distance: Float64, order: Int64, variation: Int32, step: Int32, per_node: int,
    per_variation: int, into: int, out: Bool,
) -> None:  # fmt: skip
    """Choose among pairs in order of row, then column: those of row r are first[r] to first[r + 1]; out (E,).

    `order` (E,): the pairs of each row, the nearer first. Of a row: first the nearest of each `step` (M,), then the
    nearest of each `variation` (M,), then the second nearest of each, up to `per_variation`; within each rank the
    nearer first, `per_node` in all. Of a column: the `into` nearest. Equal distances count in order of column, and of
    row.
    """
    columns = variation.shape[0]
    seen, steps = np.zeros(columns, np.int32), np.zeros(columns, np.int32)  # codes are below M
    nearest, source = np.empty((columns, into)), np.empty((columns, into), np.int64)
    held = np.zeros(columns, np.int32)
    for r in range(first.shape[0] - 1):
        begin, size = first[r], first[r + 1] - first[r]
        if size == 0:
            continue
        rank = np.empty(size, np.int32)
        number = np.zeros(per_variation + 2, np.int64)
        for n in range(size):
            j = column[order[begin + n]]
            v = variation[j]
            seen[v] += 1
            rank[n] = min(seen[v], per_variation + 1)
            if steps[step[j]] == 0:
                steps[step[j]] = 1
                rank[n] = 0
            number[rank[n]] += 1
        left = per_node
        for k in range(per_variation + 1):
            number[k] = min(number[k], left)
            left -= number[k]
        number[per_variation + 1] = 0
        for n in range(size):
            e = order[begin + n]
            j = column[e]
            seen[variation[j]] = 0
            steps[step[j]] = 0
            out[e] = number[rank[n]] > 0
            number[rank[n]] -= 1
        for e in range(begin, begin + size):
            j = column[e]
            at = held[j]
            if at == into:
                if into == 0 or distance[e] >= nearest[j, into - 1]:
                    continue
                at -= 1
            while at > 0 and nearest[j, at - 1] > distance[e]:
                nearest[j, at], source[j, at] = nearest[j, at - 1], source[j, at - 1]
                at -= 1
            nearest[j, at], source[j, at] = distance[e], e
            held[j] = min(held[j] + 1, into)
    for j in range(columns):
        for n in range(held[j]):
            out[source[j, n]] = True
