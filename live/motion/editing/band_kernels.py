"""Kernels for symmetric band matrices: Cholesky factor and solution, on one core and with the same bits on all.

LAPACK's do the same with the threads of its library, which wait for each other a hundred times longer than they work
where other processes have the cores.
"""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float64 = npt.NDArray[np.float64]


@kernel("void(f8[:,::1])")
def factor_band(band: Float64) -> None:
    """Replace a positive definite matrix A by its Cholesky factor; `band` (n, w) has A[j + d, j] at (j, d)."""
    count, width = band.shape
    for j in range(count):
        last = min(width, count - j)
        scale = 1.0 / math.sqrt(band[j, 0])
        for d in range(last):
            band[j, d] *= scale
        for d in range(1, last):
            share = band[j, d]
            for e in range(last - d):
                band[j + d, e] -= share * band[j, d + e]


@kernel("void(f8[:,::1],f8[:,::1])")
def solve_band(factor: Float64, values: Float64) -> None:
    """Replace the right hand sides `values` (m, n) by the solutions, with the factor (n, w) of `factor_band`."""
    count, width = factor.shape
    for k in range(values.shape[0]):
        for j in range(count):
            values[k, j] /= factor[j, 0]
            for d in range(1, min(width, count - j)):
                values[k, j + d] -= factor[j, d] * values[k, j]
        for j in range(count - 1, -1, -1):
            last = min(width, count - j)
            d, one, two, three, four = 1, 0.0, 0.0, 0.0, 0.0
            while d + 3 < last:  # four sums, none of which waits for another
                one += factor[j, d] * values[k, j + d]
                two += factor[j, d + 1] * values[k, j + d + 1]
                three += factor[j, d + 2] * values[k, j + d + 2]
                four += factor[j, d + 3] * values[k, j + d + 3]
                d += 4
            while d < last:
                one += factor[j, d] * values[k, j + d]
                d += 1
            values[k, j] = (values[k, j] - ((one + two) + (three + four))) / factor[j, 0]
