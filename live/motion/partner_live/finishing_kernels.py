"""Units that end in a frame, finished: the best ways that end there.

Times are frames; rings of R frames, row t % R. At each boundary the K best ways that end there are kept. Parts that the
other kernels of the reading need too stand here: what code a part becomes depends on where it was written into before,
and the sums of `finish_units` are reassociated, so its last bits would, too. From here, that kernel is always first.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel, part

Float64 = npt.NDArray[np.float64]
Complex128 = npt.NDArray[np.complex128]
Int64 = npt.NDArray[np.int64]


@part
def turn_of(z: complex) -> Any:
    """The unit number along z, 1 for none."""
    norm = np.sqrt(z.real * z.real + z.imag * z.imag)
    return complex(z.real / norm, z.imag / norm) if norm > 1e-12 else complex(1.0, 0.0)


@part
def best_way(
    score: Float64, tail: Float64, k: float, turn: complex, middle: complex, head: Complex128, up: Float64
) -> Any:
    """The best of the K ways that end with `score` (K,), ascending, at `tail` (K, 12) for a unit
    that begins at `head` (4,)."""
    best, chosen = np.inf, -1
    for way in range(score.shape[0]):
        if not score[way] < best:
            break
        away = 0.0
        if not np.isnan(tail[way, 0]):
            for b in range(4):
                place = turn * head[b] + middle
                dz, dx, dy = (
                    place.real - tail[way, 3 * b],
                    place.imag - tail[way, 3 * b + 1],
                    up[b] - tail[way, 3 * b + 2],
                )
                away += dz * dz + dx * dx + dy * dy
        value = score[way] + k * away
        if value < best:
            best, chosen = value, way
    return best, chosen


@part
def keep_way(score: Float64, cell: Int64, before: Int64, value: float, p: int, way: int) -> None:
    """Put a way among the best K, the row (K,) in order, if it is one of them."""
    last = score.shape[0] - 1
    if value >= score[last]:
        return
    at = last
    while at > 0 and score[at - 1] > value:
        at -= 1
    for n in range(last, at, -1):
        score[n], cell[n], before[n] = score[n - 1], cell[n - 1], before[n - 1]
    score[at], cell[at], before[at] = value, p, way


@part
def _end(
    at: int, p: int, x: Complex128, duration: Int64, first: Int64, offset: Int64, real: Float64, imaginary: Float64,
    tail: Complex128, tail_height: Float64, out: Float64,
) -> None:  # fmt: skip
    """Where the target of cell p ends that ends at frame `at`, into out (12,)."""
    ring, points = x.shape
    frames, row, count = duration[p], 0, 1
    for g in range(first.shape[0] - 1):
        if first[g] <= p < first[g + 1]:
            row, count = offset[g] + p - first[g], first[g + 1] - first[g]
    begin = at - frames
    product, sums = complex(0.0), complex(0.0)
    origin = x[begin % ring, 0]
    for f in range(frames + 1):
        for q in range(points):
            z = x[(begin + f) % ring, q] - origin
            sums += z
            product += complex(real[row], imaginary[row]) * z
            row += count
    turn, middle = turn_of(product), sums / (points * (frames + 1)) + origin
    for b in range(4):
        place = turn * tail[p, b] + middle
        out[3 * b], out[3 * b + 1], out[3 * b + 2] = place.real, place.imag, tail_height[p, b]


@kernel(
    "i8(i8,f8,c16[:,::1],f8[:,::1],i8[::1],i8[::1],f8[::1],f8[::1],f8[::1],f8[::1],c16[:,::1],f8[:,::1],"
    "c16[:,::1],f8[:,::1],i8[::1],f8[:,::1],f8[:,:,::1],i8[:,::1],i8[:,::1],f8[:,::1])",
    fastmath={"reassoc", "contract", "nsz"},
)
def finish_units(
    at: int,
    k: float,
    x: Complex128,
    x_height: Float64,
    duration: Int64,
    offset: Int64,
    real: Float64,
    imaginary: Float64,
    heights: Float64,
    size: Float64,
    head: Complex128,
    head_height: Float64,
    tail: Complex128,
    tail_height: Float64,
    first: Int64,
    score: Float64,
    end: Float64,
    cell: Int64,
    before: Int64,
    work: Float64,
) -> int:
    """The cells that end at frame `at`, if it is a boundary: the K best into row at % R; how many were scored.

    x (R, P) and x_height: the input; duration, size, head, tail of the P cells as in Stretches; the G durations have
    the cells first[g] to first[g + 1] - 1, whose centred controls lie at offset[g] of real, imaginary and heights
    (points by cells). score (R, K), end (R, K, 12), cell and before (R, K): what ends at each boundary, infinite
    scores for none; work (4, P) is scratch.
    """
    ring, points = x.shape
    scored = 0
    slot = at % ring
    for g in range(first.shape[0] - 1):
        low, high = first[g], first[g + 1]
        frames = duration[low]
        begin = at - frames
        if begin < 0 or not np.isfinite(score[begin % ring, 0]):
            continue
        count = high - low
        re, im, up = work[0, :count], work[1, :count], work[2, :count]
        re[:], im[:], up[:] = 0.0, 0.0, 0.0
        origin, sums, squares, row = x[begin % ring, 0], complex(0.0), 0.0, offset[g]
        for f in range(frames + 1):
            for p in range(points):
                z = x[(begin + f) % ring, p] - origin
                y = x_height[(begin + f) % ring, p]
                sums += z
                squares += z.real * z.real + z.imag * z.imag + y * y
                a, b, h = real[row : row + count], imaginary[row : row + count], heights[row : row + count]
                for c in range(count):
                    re[c] += a[c] * z.real - b[c] * z.imag
                    im[c] += a[c] * z.imag + b[c] * z.real
                    up[c] += h[c] * y
                row += count
        n = points * (frames + 1)
        middle = sums / n
        squares -= n * (middle.real * middle.real + middle.imag * middle.imag)
        middle += origin
        for c in range(count):
            p = low + c
            z = complex(re[c], im[c])
            turn = turn_of(z)
            best, way = best_way(score[begin % ring], end[begin % ring], k, turn, middle, head[p], head_height[p])
            value = best + squares + size[p] - 2.0 * (np.abs(z) + up[c])
            scored += 1
            if way >= 0:
                keep_way(score[slot], cell[slot], before[slot], value, p, way)
    for way in range(score.shape[1]):
        if np.isfinite(score[slot, way]) and cell[slot, way] >= 0:
            _end(at, cell[slot, way], x, duration, first, offset, real, imaginary, tail, tail_height, end[slot, way])
    return scored
