"""Kernels that fit single units at every place of an input and find the best sequence of places (H012)."""

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel

Float64 = npt.NDArray[np.float64]
Complex128 = npt.NDArray[np.complex128]
Int64 = npt.NDArray[np.int64]


@inline_kernel
def _read(out: Float64, row: int, floor: Complex128, height: Float64, place: float) -> None:
    """Write the points at fractional sample `place`, clamped to the ends, to `out`: z, x, height of each in turn."""
    last = floor.shape[0] - 1
    place = min(max(place, 0.0), float(last))
    low = min(int(place), max(last - 1, 0))
    high = min(low + 1, last)
    w = place - low
    for p in range(floor.shape[1]):
        one = (1.0 - w) * floor[low, p] + w * floor[high, p]
        out[row, 3 * p] = one.real
        out[row, 3 * p + 1] = one.imag
        out[row, 3 * p + 2] = (1.0 - w) * height[low, p] + w * height[high, p]


@kernel(
    "void(c16[:,::1],f8[:,::1],c16[:,::1],f8[:,::1],c16[:,::1],f8[:,::1],f8,f8,i8,i8,i8,i8,"
    "f8[:,:,::1],f8[:,:,::1],f8[:,:,::1])"
)
def fit_places(
    x: Complex128,
    x_height: Float64,
    control: Complex128,
    control_height: Float64,
    target: Complex128,
    target_height: Float64,
    start: float,
    length: float,
    first_begin: int,
    first_end: int,
    shortest: int,
    longest: int,
    fits: Float64,
    head: Float64,
    tail: Float64,
) -> None:
    """Fit one unit to the input from every frame first_begin + i to every frame first_end + j.

    x is (T, P), control (S, P), target (S, 4), each with heights. The unit is the samples `start` to `start + length`
    of control and target. Durations below `shortest` and above `longest` are skipped. found (I, J, 5) receives D, then
    M as turn and shift (real, imaginary). head and tail (I, J, 12) receive the target's end samples moved by M.
    """
    points = x.shape[1]
    a = np.empty((1, 3 * points))
    b = np.empty((1, 12))
    for i in range(fits.shape[0]):
        for j in range(fits.shape[1]):
            begin, end = first_begin + i, first_end + j
            frames = end - begin
            if frames < shortest or frames > longest:
                continue
            sx, sa, product = complex(0.0), complex(0.0), complex(0.0)
            square, rise = 0.0, 0.0
            origin = x[begin, 0]
            for f in range(frames + 1):
                _read(a, 0, control, control_height, start + f * (length / frames))
                for p in range(points):
                    xf = x[begin + f, p] - origin
                    af = complex(a[0, 3 * p], a[0, 3 * p + 1])
                    sx += xf
                    sa += af
                    product += af.conjugate() * xf
                    square += xf.real * xf.real + xf.imag * xf.imag + af.real * af.real + af.imag * af.imag
                    up = x_height[begin + f, p] - a[0, 3 * p + 2]
                    rise += up * up
            n = points * (frames + 1)
            mx, ma = sx / n, sa / n
            product -= n * (ma.conjugate() * mx)
            square -= n * (mx.real * mx.real + mx.imag * mx.imag + ma.real * ma.real + ma.imag * ma.imag)
            norm = np.sqrt(product.real * product.real + product.imag * product.imag)
            turn = product / norm if norm > 1e-12 else complex(1.0)
            shift = mx + origin - turn * ma
            fits[i, j, 0] = square - 2.0 * norm + rise
            fits[i, j, 1], fits[i, j, 2] = turn.real, turn.imag
            fits[i, j, 3], fits[i, j, 4] = shift.real, shift.imag
            for side in range(2):
                _read(b, 0, target, target_height, start + side * length)
                for p in range(4):
                    place = turn * complex(b[0, 3 * p], b[0, 3 * p + 1]) + shift
                    if side == 0:
                        head[i, j, 3 * p], head[i, j, 3 * p + 1] = place.real, place.imag
                        head[i, j, 3 * p + 2] = b[0, 3 * p + 2]
                    else:
                        tail[i, j, 3 * p], tail[i, j, 3 * p + 1] = place.real, place.imag
                        tail[i, j, 3 * p + 2] = b[0, 3 * p + 2]


@kernel("void(f8[:,::1],f8[:,:,::1],f8[:,:,::1],f8[:,:,::1],f8,f8[:,::1],i8[:,::1])")
def join_places(
    before: Float64, tail: Float64, fits: Float64, head: Float64, k: float, score: Float64, back: Int64
) -> None:
    """Compute the best scores (J, L) of cells of a unit that begin where cells of the previous unit end.

    before (I, J) holds the scores of the previous unit's cells, tail (I, J, 12) their last samples. found (J, L, 5) and
    head (J, L, 12) come from `fit_places`. back (J, L) receives the begin I of the best previous cell.
    """
    for j in range(score.shape[0]):
        for m in range(score.shape[1]):
            if not np.isfinite(fits[j, m, 0]):
                continue
            best, chosen = np.inf, -1
            for i in range(before.shape[0]):
                if not before[i, j] < best:
                    continue
                away = 0.0
                for c in range(12):
                    d = tail[i, j, c] - head[j, m, c]
                    away += d * d
                value = before[i, j] + k * away
                if value < best:
                    best, chosen = value, i
            if chosen >= 0:
                score[j, m] = best + fits[j, m, 0]
                back[j, m] = chosen
