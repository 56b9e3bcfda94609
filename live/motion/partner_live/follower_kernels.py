"""Kernels of the learnt follower: what a leader does, how like recorded moments it is, and where the follower is.

Sums run over the last axis of an array and keep their order, so that a processor's vectors do not change a bit.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel

Float64 = npt.NDArray[np.float64]
Complex128 = npt.NDArray[np.complex128]
Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]


@inline_kernel
def _facing(left: complex, right: complex) -> complex:
    """Return where hips face whose joints are at `left` and `right`, as a unit complex number."""
    across = left - right
    size = abs(across)
    return -1j * across / size if size > 1e-9 else complex(1.0)


@kernel("void(i8,i8,c16[:,::1],f8[:,::1],i8[::1],f8[::1])")
def write_features(at: int, first: int, floor: Complex128, height: Float64, lags: Int64, out: Float64) -> None:
    """Write what a leader does at frame `at` to out (L · (3 P - 1),).

    `floor` and `height` (R, P) are rings of points, row t % R, the two hip joints first; frames before `first` are
    taken as `first`. For each of the `lags` (L,) [frames]: the middle of the hips and all other points, z, y, x in the
    frame of the hips at `at` [m], and the direction in which the hips faced. Points that were not seen are not a
    number.
    """
    ring, points = floor.shape
    row = at % ring
    middle = 0.5 * (floor[row, 0] + floor[row, 1])
    back = np.conj(_facing(floor[row, 0], floor[row, 1]))
    n = 0
    for lag in lags:
        row = max(at - lag, first) % ring
        place = (0.5 * (floor[row, 0] + floor[row, 1]) - middle) * back
        out[n], out[n + 1], out[n + 2] = place.real, 0.5 * (height[row, 0] + height[row, 1]), place.imag
        n += 3
        for p in range(2, points):
            place = (floor[row, p] - middle) * back
            out[n], out[n + 1], out[n + 2] = place.real, height[row, p], place.imag
            n += 3
        turned = _facing(floor[row, 0], floor[row, 1]) * back
        out[n], out[n + 1] = turned.real, turned.imag
        n += 2


@kernel("void(f8[::1],f8[:,::1],f8[::1],i8,f8[::1],f8[::1])")
def square_distances(
    feature: Float64, moments: Float64, share: Float64, near: int, near_square: Float64, square: Float64
) -> None:
    """Write squared distances of `feature` (D,) from `moments` (D, M), in shares of their mean square.

    `square` (M,) is of all features, `near_square` (M,) of the first `near`. `share` (D,) is each feature's part of the
    mean square; features that are not a number count as if they were as far away as all others.
    """
    near_square[:] = 0.0
    square[:] = 0.0
    seen = 0.0
    for d in range(feature.shape[0]):
        if d == near:
            near_square[:] = square / max(seen, 1e-12)
        if feature[d] == feature[d]:
            seen += share[d]
            value, row = feature[d], moments[d]
            for m in range(square.shape[0]):
                away = row[m] - value
                square[m] += away * away
    square /= max(seen, 1e-12)


@kernel("f8(f8[::1],f8,f8[:,::1],f8[::1],f8[::1])")
def regress(square: Float64, width: float, weights: Float64, mean: Float64, out: Float64) -> float:
    """Write the kernel regression's prediction (O,) to `out`; return the largest similarity to a moment, 0 to 1.

    `square` (M,) is of `square_distances`, `width` of the Gaussian kernel, `weights` (M, O), and `mean` (O,) what is
    predicted if no moment is like it.
    """
    out[:] = mean
    nearest = 0.0
    for m in range(square.shape[0]):
        like = math.exp(-square[m] / (2.0 * width * width))
        nearest = max(nearest, like)
        if like > 1e-7:
            row = weights[m]
            for n in range(out.shape[0]):
                out[n] += like * row[n]
    return nearest


STAY: Any = 0.1
GO_ON: Any = 0.8
SKIP: Any = 0.1
"""Probabilities that a leader is slower, as fast or faster than recorded by a moment a step, if she goes on."""
ANYWHERE: Any = 1e-5
"""Probability of a moment that nothing leads to, all together."""
EXACT_WIDTH: Any = 0.05
EXACT_GAIN: Any = 4.0
"""A leader who dances as recorded, within the width, is so much likelier to be at that moment."""
NEGLIGIBLE: Any = 1e-9
"""Moments less probable than this do not jump."""


@kernel("f8(f8[::1],i8[::1],i4[:,::1],f8[:,::1],f8,f8[::1],f8,f8[::1],f8,f8[::1])")
def advance_posterior(
    posterior: Float64,
    follows: Int64,
    jump_to: Int32,
    jump_share: Float64,
    jump: float,
    square: Float64,
    width: float,
    on_beat: Float64,
    trust: float,
    scratch: Float64,
) -> float:
    """Advance the probabilities of M moments by one step, in place; return how much likelier the beats make what is
    seen, 1 if they say nothing.

    `follows` (M,): how many moments of its recording follow each, at most 2; `jump_to` and `jump_share` (M, K): where
    each leads with the probability `jump`; `square` (M,) of `square_distances`; `on_beat` (M,), or (0,) without beats:
    the density of the leader's beats at each moment over that without any beats, believed with the probability `trust`;
    `scratch` (M,).
    """
    count = posterior.shape[0]
    scratch[:] = ANYWHERE / count
    for m in range(count):
        p = posterior[m]
        if p < NEGLIGIBLE:
            continue
        stays = p * (1.0 - jump)
        scratch[m] += STAY * stays
        if follows[m] > 0:
            scratch[m + 1] += GO_ON * stays
        if follows[m] > 1:
            scratch[m + 2] += SKIP * stays
        for n in range(jump_to.shape[1]):
            scratch[jump_to[m, n]] += p * jump * jump_share[m, n]
    least = square.min()
    total, with_beats = 0.0, 0.0
    for m in range(count):
        like = math.exp(-(square[m] - least) / (2.0 * width * width))
        exact = math.exp(-square[m] / (2.0 * EXACT_WIDTH * EXACT_WIDTH))
        posterior[m] = scratch[m] * like * (1.0 + EXACT_GAIN * exact)
        total += posterior[m]
    if on_beat.shape[0] == count:
        for m in range(count):
            with_beats += posterior[m] * on_beat[m]
            posterior[m] *= 1.0 - trust + trust * on_beat[m]
        evidence = with_beats / total
        total = 0.0
        for m in range(count):
            total += posterior[m]
    else:
        evidence = 1.0
    for m in range(count):
        posterior[m] /= total
    return evidence


SURE_POWER: Any = 4
"""Power of the probabilities in the mean of the facing: between two directions the middle one would be none of both."""


@kernel("void(f8[::1],f8[:,::1],i8[::1],i8,f8[::1],f8[::1])")
def posterior_means(
    posterior: Float64, target: Float64, follows: Int64, facing: int, now: Float64, soon: Float64
) -> None:
    """Write the mean of `target` (M, O) over the `posterior` (M,) to `now` (O,), and that a step later to `soon`.

    Of the two columns from `facing` on, the likeliest moments count most.
    """
    now[:] = 0.0
    soon[:] = 0.0
    sure, sure_z, sure_x, soon_z, soon_x = 0.0, 0.0, 0.0, 0.0, 0.0
    for m in range(posterior.shape[0]):
        p = posterior[m]
        if p < NEGLIGIBLE:
            continue
        row, other = target[m], target[m + min(follows[m], 1)]
        for n in range(now.shape[0]):
            now[n] += p * row[n]
            soon[n] += p * other[n]
        w = p**SURE_POWER
        sure += w
        sure_z, sure_x = sure_z + w * row[facing], sure_x + w * row[facing + 1]
        soon_z, soon_x = soon_z + w * other[facing], soon_x + w * other[facing + 1]
    now[facing], now[facing + 1] = sure_z / sure, sure_x / sure
    soon[facing], soon[facing + 1] = soon_z / sure, soon_x / sure


@kernel("void(f8[::1],f8[::1],f8[:,::1],f8[::1],f8[:,::1],f8[::1])")
def danced_costs(wanted: Float64, change: Float64, shown: Float64, own: Float64, body: Float64, cost: Float64) -> None:
    """Write what it costs to dance each of M moments to `cost` (M,) [m²].

    `wanted` (V,) is the follower as expected, `change` (V,) how that changes in a step; `shown` (2 V, M) has the same
    of all moments. `own` (B,) is the body that is shown now, `body` (B, M) that of all moments.
    """
    cost[:] = 0.0
    size = wanted.shape[0]
    for n in range(size):
        for m in range(cost.shape[0]):
            away, apart = shown[n, m] - wanted[n], shown[size + n, m] - change[n]
            cost[m] += away * away + apart * apart
    for n in range(own.shape[0]):
        for m in range(cost.shape[0]):
            away = body[n, m] - own[n]
            cost[m] += away * away


@inline_kernel
def _substitute(matrix: Float64, right: Float64) -> None:
    """Solve L · Lᵀ · x = right in place, for the lower triangle L of `matrix`."""
    count = matrix.shape[0]
    columns = right.shape[1]
    for i in range(count):
        for j in range(i):
            for n in range(columns):
                right[i, n] -= matrix[i, j] * right[j, n]
        for n in range(columns):
            right[i, n] /= matrix[i, i]
    for i in range(count - 1, -1, -1):
        for n in range(columns):
            right[i, n] /= matrix[i, i]
        for j in range(i):
            for n in range(columns):
                right[j, n] -= matrix[i, j] * right[i, n]


@kernel("void(f8[:,::1],f8[:,::1])")
def solve_positive(matrix: Float64, right: Float64) -> None:
    """Solve matrix · x = right by Cholesky's decomposition, in place: `matrix` (M, M) is positive definite, `right`
    (M, O) becomes x."""
    count = matrix.shape[0]
    for i in range(count):
        one = matrix[i]
        for j in range(i + 1):
            other = matrix[j]
            a, b, c, d = 0.0, 0.0, 0.0, 0.0
            whole = j - j % 4
            for k in range(0, whole, 4):
                a += one[k] * other[k]
                b += one[k + 1] * other[k + 1]
                c += one[k + 2] * other[k + 2]
                d += one[k + 3] * other[k + 3]
            for k in range(whole, j):
                a += one[k] * other[k]
            left = one[j] - ((a + b) + (c + d))
            one[j] = math.sqrt(left) if i == j else left / other[j]
    _substitute(matrix, right)
