"""How useful each recorded take is to predict the follower in the others, and the weight that it gets for that (H026).

Take i is predicted by kernel ridge regression from all others, once with take j among them and once without. The *gain*
of j for i is ln(error without j / error with j), and the usefulness of j is the median of its gains over all i, so that
one odd take does not spoil the judgement of the good ones. Its weight is exp(GAIN_SHARPNESS · min(usefulness, 0)), from
MIN_WEIGHT to 1: a take that helps the others, or says nothing of them, counts in full.

Nothing is learnt again for each pair of takes. If G is the inverse of the kernel matrix with its ridge, the residuals
of rows B that are left out together are G[B, B]⁻¹ · (G · targets)[B]: S. An, W. Liu, S. Venkatesh, *Fast
cross-validation algorithms for least squares support vector machine and kernel ridge regression* (2007).
"""

from typing import Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.motion.partner_live.follower_kernels import solve_positive

GAIN_SHARPNESS: Final = 40.0
"""How fast a weight falls with the logarithm of the others' errors."""
MIN_WEIGHT: Final = 0.05
"""Least weight of a take: it may still be danced where no other one fits."""
MIN_TAKES: Final = 3
MAX_TAKES: Final = 64
"""With fewer or more takes all of them count in full: fewer cannot be told apart, and more leave too little of each."""
MIN_MOMENTS: Final = 75
"""A shorter take, of ten seconds, counts in full and does not judge others."""
JUDGED_MOMENTS: Final = 600
"""About so many moments are looked at, the same share of each take."""
CONSTANT: Final = 10.0
"""Variance of the constant term, which is estimated with the rest."""
WEIGHT_STEP: Final = 1.0 / 64.0
"""Weights are rounded to this, so that the last bits of a library do not matter."""


def judged_rows(example: Int64) -> Int64 | None:
    """Return the moments by which takes are judged, of `example` (M,), the take of each; None if none can be.

    `example` is ascending, 7.5 moments a second.
    """
    takes, count = np.unique(example, return_counts=True)
    long = takes[count >= MIN_MOMENTS]
    if not MIN_TAKES <= len(long) <= MAX_TAKES:
        return None
    rows = np.flatnonzero(np.isin(example, long))
    return np.asarray(rows[:: max(1, -(-len(rows) // JUDGED_MOMENTS))], np.int64)


def example_gains(kernel: Float64, target: Float64, example: Int64) -> Float64:
    """Return gains of T takes for each other, [which is predicted, which helps], (T, T); NaN with itself.

    `kernel` (n, n) is that of moments, with its ridge; `target` (n, 3 · K) are K points of the follower [m]; `example`
    (n,) the take of each moment, in ascending order of takes.
    """
    inverse, matrix = np.eye(len(kernel)), np.ascontiguousarray(kernel + CONSTANT)
    solve_positive(matrix, inverse)
    given = inverse @ target
    takes = [np.flatnonzero(example == one) for one in np.unique(example)]
    alone = [_left_out_error(inverse, given, rows, len(rows)) for rows in takes]
    gains = np.full((len(takes), len(takes)), np.nan)
    for i, rows in enumerate(takes):
        for j, others in enumerate(takes):
            if i != j:
                without = _left_out_error(inverse, given, np.concatenate((rows, others)), len(rows))
                gains[i, j] = np.log(max(without, 1e-6) / max(alone[i], 1e-6))
    return gains


def _left_out_error(inverse: Float64, given: Float64, rows: Int64, count: int) -> float:
    """Return the mean error of points of the first `count` of `rows` if all of `rows` are left out [m]."""
    residual = np.ascontiguousarray(given[rows])
    solve_positive(np.ascontiguousarray(inverse[np.ix_(rows, rows)]), residual)
    return float(np.linalg.norm(residual[:count].reshape(count, -1, 3), axis=-1).mean())


def weights_of_gains(gains: Float64) -> Float64:
    """Return the weights of T takes, (T,), from `example_gains` (T, T)."""
    usefulness = np.nanmedian(gains, axis=0)
    weight = np.exp(GAIN_SHARPNESS * np.minimum(usefulness, 0.0))
    return np.asarray(np.clip(np.round(weight / WEIGHT_STEP) * WEIGHT_STEP, MIN_WEIGHT, 1.0))
