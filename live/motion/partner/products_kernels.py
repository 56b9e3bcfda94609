"""Windows of an input times all cells of a length, as of matrices (K003)."""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float64 = npt.NDArray[np.float64]
Complex128 = npt.NDArray[np.complex128]

WIDE: Any = 32
"""Cells that are multiplied side by side."""


@kernel(
    "void(c16[:,::1],f8[:,::1],i8,f8[:,::1],f8[:,::1],f8[:,::1],i8,c16[:,::1],f8[:,::1])",
    fastmath={"reassoc", "contract", "nsz"},
)
def multiply(
    floor: Complex128,
    height: Float64,
    frames: int,
    real: Float64,
    imaginary: Float64,
    heights: Float64,
    first: int,
    product: Complex128,
    height_product: Float64,
) -> None:
    """Windows of `frames` samples of an input times all cells of that length, for U windows one sample apart.

    floor (F, C) and height (F, C): the input from the first window on; real, imaginary and heights (frames C,
    cells): the cells; product (U, P) and height_product (U, P) receive the columns from `first` on.
    """
    points, cells = floor.shape[1], real.shape[1]
    re0, im0, up0 = np.empty(WIDE), np.empty(WIDE), np.empty(WIDE)
    re1, im1, up1 = np.empty(WIDE), np.empty(WIDE), np.empty(WIDE)
    a, b, h = np.empty(WIDE), np.empty(WIDE), np.empty(WIDE)
    count = product.shape[0]
    for low in range(0, cells, WIDE):
        width = min(WIDE, cells - low)
        for u in range(0, count, 2):
            other = min(u + 1, count - 1)
            re0[:], im0[:], up0[:], re1[:], im1[:], up1[:] = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for n in range(frames * points):
                f, p = n // points, n % points
                z0, z1 = floor[u + f, p], floor[other + f, p]
                y0, y1 = height[u + f, p], height[other + f, p]
                for c in range(width):
                    a[c], b[c], h[c] = real[n, low + c], imaginary[n, low + c], heights[n, low + c]
                for c in range(WIDE):
                    re0[c] += a[c] * z0.real - b[c] * z0.imag
                    im0[c] += a[c] * z0.imag + b[c] * z0.real
                    up0[c] += h[c] * y0
                    re1[c] += a[c] * z1.real - b[c] * z1.imag
                    im1[c] += a[c] * z1.imag + b[c] * z1.real
                    up1[c] += h[c] * y1
            for c in range(width):
                product[u, first + low + c] = complex(re0[c], im0[c])
                product[other, first + low + c] = complex(re1[c], im1[c])
                height_product[u, first + low + c] = up0[c]
                height_product[other, first + low + c] = up1[c]
