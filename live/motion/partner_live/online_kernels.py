"""Kernels of the causal decoder: finish units that end in a frame, score running units, expect the follower's position.

Times are frames; buffers are rings of R frames, row t % R. At each boundary the K best paths that end there are kept.
The functions shared by these kernels are defined in this module on purpose: the machine code of an inlined function
depends on where it was compiled before, and the sums of `finish_units` are reassociated, so its last bits would depend
on it too. Here that kernel is always compiled first.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.partner.decoder_kernels import unit_complex

Float64 = npt.NDArray[np.float64]
Complex128 = npt.NDArray[np.complex128]
Int64 = npt.NDArray[np.int64]


@inline_kernel
def best_path(
    score: Float64, tail: Float64, k: float, turn: complex, middle: complex, head: Complex128, up: Float64
) -> Any:
    """Return the best of the K paths that end with `score` (K,), ascending, at `tail` (K, 12).

    The unit that follows begins at `head` (4,).
    """
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


@inline_kernel
def insert_path(score: Float64, cell: Int64, before: Int64, value: float, p: int, path: int) -> None:
    """Insert a path into the sorted row (K,) of the K best if it is good enough."""
    last = score.shape[0] - 1
    if value >= score[last]:
        return
    at = last
    while at > 0 and score[at - 1] > value:
        at -= 1
    for n in range(last, at, -1):
        score[n], cell[n], before[n] = score[n - 1], cell[n - 1], before[n - 1]
    score[at], cell[at], before[at] = value, p, path


@inline_kernel
def _cell_end(
    at: int, p: int, x: Complex128, duration: Int64, first: Int64, offset: Int64, real: Float64, imaginary: Float64,
    tail: Complex128, tail_height: Float64, out: Float64,
) -> None:  # fmt: skip
    """Write the end of the target of cell p, which ends at frame `at`, to out (12,)."""
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
    turn, middle = unit_complex(product), sums / (points * (frames + 1)) + origin
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
    """Write the K best cells that end at frame `at`, a boundary, to row at % R; return how many were scored.

    x (R, P) and x_height: the input; duration, size, head, tail of the P cells as in Stretches; the G durations have
    the cells first[g] to first[g + 1] - 1, whose centred controls lie at offset[g] of real, imaginary and heights
    (points by cells). score (R, K), end (R, K, 12), cell and before (R, K): the paths that end at each boundary,
    infinite scores for none; work (4, P) is scratch.
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
            turn = unit_complex(z)
            best, way = best_path(score[begin % ring], end[begin % ring], k, turn, middle, head[p], head_height[p])
            value = best + squares + size[p] - 2.0 * (np.abs(z) + up[c])
            scored += 1
            if way >= 0:
                insert_path(score[slot], cell[slot], before[slot], value, p, way)
    for way in range(score.shape[1]):
        if np.isfinite(score[slot, way]) and cell[slot, way] >= 0:
            _cell_end(
                at, cell[slot, way], x, duration, first, offset, real, imaginary, tail, tail_height, end[slot, way]
            )
    return scored


LATE_SHARE: Any = 0.1
"""A unit may exceed its length by this share and still count for the follower's position."""
MAX_LOG_WEIGHT: Any = 8.0
"""Units with a weight below e to the minus this are left out."""


@inline_kernel
def _root_at(root: Complex128, facing: Complex128, first: int, stop: int, place: float) -> Any:
    """Return a recording's hips on the floor and their facing at its sample `place`."""
    place = min(max(place, 0.0), float(stop - first - 1))
    low = min(int(place), max(stop - first - 2, 0))
    w = place - low
    one, other = first + low, min(first + low + 1, stop - 1)
    return (1.0 - w) * root[one] + w * root[other], (1.0 - w) * facing[one] + w * facing[other]


@kernel(
    "i8(f8,f8,i8,c16[:,::1],c16[::1],c16[::1],i8[::1],i8[::1],f8[::1],f8[::1],f8[:,::1],c16[:,:,::1],c16[::1],f8[:,::1],"
    "f8[:,::1],c16[::1])"
)
def expect_root(
    spread: float,
    min_frames: float,
    at: int,
    x: Complex128,
    root: Complex128,
    facing: Complex128,
    record_first: Int64,
    record_stop: Int64,
    start: Float64,
    length: Float64,
    step: Float64,
    sums: Complex128,
    input_sum: Complex128,
    frames: Float64,
    value: Float64,
    found: Complex128,
) -> int:
    """Compute the follower's expected hips at frame `at`, the mean over all running units; return their number.

    Only boundaries with at least `min_frames` observed frames count: fewer do not determine a unit's position. A unit
    whose score `value` (R, N) is worse than the best by v [m²] weighs exp(-v / spread). root and facing (S,): of the
    followers in all recordings; length (N,) [samples] of the units; the others as in `score_running`. found (2,): the
    position and the facing (not normalized); unchanged if no unit runs.
    """
    ring, points = x.shape
    best = np.inf
    for row in range(ring):
        if frames[row, 0] < min_frames:
            continue
        for unit in range(start.shape[0]):
            if (frames[row, 0] - 1.0) * step[row, unit] <= length[unit] * (1.0 + LATE_SHARE):
                best = min(best, value[row, unit])
    if not np.isfinite(best):
        return 0
    weights, place, front, count = 0.0, complex(0.0), complex(0.0), 0
    for row in range(ring):
        if frames[row, 0] < min_frames:
            continue
        seen = frames[row, 0] - 1.0
        begin = at - int(seen)
        n = points * (seen + 1.0)
        middle = input_sum[row] / n
        for unit in range(start.shape[0]):
            worse = value[row, unit] - best
            if not worse < MAX_LOG_WEIGHT * spread or seen * step[row, unit] > length[unit] * (1.0 + LATE_SHARE):
                continue
            own = sums[row, unit, 1] / n
            turn = unit_complex(sums[row, unit, 0] - n * own.conjugate() * middle)
            here, front_here = _root_at(
                root, facing, record_first[unit], record_stop[unit], start[unit] + seen * step[row, unit]
            )
            weight = np.exp(-worse / spread)
            weights += weight
            place += weight * (turn * (here - own) + middle + x[begin % ring, 0])
            front += weight * turn * front_here
            count += 1
    found[0], found[1] = place / weights, front / weights
    return count


MIN_BEAM_FRAMES: Any = 5.0
"""No boundary is dropped before this many frames are observed."""


@inline_kernel
def _sample(floor: Complex128, height: Float64, first: int, stop: int, place: float, p: int) -> Any:
    """Return point p of a recording with samples `first` to `stop` - 1 at its sample `place`."""
    place = min(max(place, 0.0), float(stop - first - 1))
    low = min(int(place), max(stop - first - 2, 0))
    w = place - low
    one, other = first + low, min(first + low + 1, stop - 1)
    return (1.0 - w) * floor[one, p] + w * floor[other, p], (1.0 - w) * height[one, p] + w * height[other, p]


@kernel(
    "void(i8,f8,c16[:,::1],f8[:,::1],c16[:,::1],f8[:,::1],i8[::1],i8[::1],f8[::1],f8[:,::1],c16[:,::1],f8[:,::1],"
    "f8[:,::1],f8[:,:,::1],c16[:,:,::1],f8[:,:,::1],c16[::1],f8[:,::1],f8[:,::1],f8[:,::1],f8)"
)
def score_running(
    at: int,
    k: float,
    x: Complex128,
    x_height: Float64,
    control: Complex128,
    control_height: Float64,
    record_first: Int64,
    record_stop: Int64,
    start: Float64,
    step: Float64,
    head: Complex128,
    head_height: Float64,
    score: Float64,
    end: Float64,
    sums: Complex128,
    squares: Float64,
    input_sum: Complex128,
    input_square: Float64,
    frames: Float64,
    value: Float64,
    beam: float,
) -> None:
    """Score all units that run at frame `at` by their observed part: value (R, N) for each boundary and unit.

    control (S, P): the samples of all recordings; of unit n they are record_first[n] to record_stop[n] - 1, and it
    begins at the sample start[n] of those; step (R, N): samples per frame by the clock, 0 if a unit does not run. head
    (N, 4): the unit's first target sample. sums (R, N, 2): running conj(a) · x and sum of a; squares (R, N, 2): running
    |a|² and squared differences of heights; input_sum (R,), input_square (R, 1), frames (R, 1): of the input since each
    boundary. A boundary whose units are all worse than the best of all by more than `beam` [m²] is dropped: its frames
    become -1.
    """
    ring, points = x.shape
    best_of_all = np.inf
    for row in range(ring):
        if not np.isfinite(score[row, 0]) or frames[row, 0] < 0.0:
            continue
        seen = int(frames[row, 0])
        begin = at - seen
        origin = x[begin % ring, 0]
        for p in range(points):
            z = x[at % ring, p] - origin
            input_sum[row] += z
            input_square[row, 0] += z.real * z.real + z.imag * z.imag
        n = points * (seen + 1)
        middle = input_sum[row] / n
        for unit in range(start.shape[0]):
            if step[row, unit] <= 0.0:
                value[row, unit] = np.inf
                continue
            place = start[unit] + seen * step[row, unit]
            for p in range(points):
                a, y = _sample(control, control_height, record_first[unit], record_stop[unit], place, p)
                z = x[at % ring, p] - origin
                sums[row, unit, 0] += a.conjugate() * z
                sums[row, unit, 1] += a
                squares[row, unit, 0] += a.real * a.real + a.imag * a.imag
                rise = x_height[at % ring, p] - y
                squares[row, unit, 1] += rise * rise
            own = sums[row, unit, 1] / n
            product = sums[row, unit, 0] - n * own.conjugate() * middle
            left = input_square[row, 0] - n * (middle.real * middle.real + middle.imag * middle.imag)
            left += squares[row, unit, 0] - n * (own.real * own.real + own.imag * own.imag)
            turn = unit_complex(product)
            shift = middle + origin - turn * own
            best, way = best_path(score[row], end[row], k, turn, shift, head[unit], head_height[unit])
            value[row, unit] = best + left - 2.0 * np.abs(product) + squares[row, unit, 1]
            if way < 0:
                value[row, unit] = np.inf
            best_of_all = min(best_of_all, value[row, unit])
        frames[row, 0] += 1.0
    for row in range(ring):
        if frames[row, 0] > MIN_BEAM_FRAMES and value[row].min() > best_of_all + beam:
            frames[row, 0] = -1.0
