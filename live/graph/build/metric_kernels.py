"""Kernels of the metric: pairs of a block that may be near, and their products in double precision."""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Complex64 = npt.NDArray[np.complex64]
Complex128 = npt.NDArray[np.complex128]

_TWO: Any = np.float32(2.0)


@kernel("i8(c8[:,::1],f4[:,::1],f4[::1],f4[::1],f4,f4,i4[:,::1],i4[:,::1],i4[::1],i4[::1])")
def filter_block(
    product: Complex64,
    height: Float32,
    size_a: Float32,
    size_b: Float32,
    limit: float,
    tolerance: float,
    codes_a: Int32,
    codes_b: Int32,
    out_row: Int32,
    out_column: Int32,
) -> int:
    """Find pairs of a block whose squared distance (K003) is at most `limit` [m²], plus `tolerance` · sizes.

    product (B, M) of floor coordinates, height (B, M) of heights (overwritten); size_a (B,), size_b (M,) as in
    FlatClouds; codes_a (B, 2) and codes_b (M, 2): end or begin pose (agree if equal, or either -1), and what may not
    be repeated (refused if equal, and not negative). Row and column of each pair go to out_row and out_column, which
    hold B · M; returns the number of pairs.
    """
    count = 0
    for i in range(product.shape[0]):
        a = size_a[i]
        for j in range(product.shape[1]):
            z = product[i, j]
            height[i, j] = a + size_b[j] - _TWO * (np.sqrt(z.real * z.real + z.imag * z.imag) + height[i, j])
        for j in range(product.shape[1]):
            if height[i, j] > limit + tolerance * (a + size_b[j]):
                continue
            end, begin = codes_a[i, 0], codes_b[j, 0]
            if end != begin and end >= 0 and begin >= 0:
                continue
            if codes_a[i, 1] == codes_b[j, 1] and codes_a[i, 1] >= 0:
                continue
            out_row[count] = i
            out_column[count] = j
            count += 1
    return count


@kernel(
    "void(c16[:,::1],f8[:,::1],c16[:,::1],f8[:,::1],i4[::1],i4[::1],c16[::1],f8[::1])",
    fastmath={"reassoc", "contract"},
)
def pair_products(
    floor_a: Complex128,
    height_a: Float64,
    floor_b: Complex128,
    height_b: Float64,
    row: Int32,
    column: Int32,
    out_product: Complex128,
    out_height: Float64,
) -> None:
    """Write conj(a) · b and y_a · y_b for the pairs (row, column) (E,) of clouds (N, P) and (M, P) to (E,) each."""
    points = floor_a.shape[1]
    for e in range(row.shape[0]):
        i, j = row[e], column[e]
        re0, re1, im0, im1, y0 = 0.0, 0.0, 0.0, 0.0, 0.0
        for p in range(points):
            a, b = floor_a[i, p], floor_b[j, p]  # sums in any order, to allow SIMD
            re0 += a.real * b.real
            re1 += a.imag * b.imag
            im0 += a.real * b.imag
            im1 += a.imag * b.real
            y0 += height_a[i, p] * height_b[j, p]
        out_product[e] = complex(re0 + re1, im0 - im1)
        out_height[e] = y0
