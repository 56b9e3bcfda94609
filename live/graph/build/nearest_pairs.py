"""All pairs of clouds within a threshold, for libraries of any size (K003).

Blocks of rows pass a filter in single precision: one complex and one real matrix product of coarse clouds (parabolas in
time, a quarter of the numbers), and a kernel that keeps the pairs that can be near enough. Coarse clouds are never
farther apart than the clouds themselves. Only those pairs are computed in double precision, one by one, or as a block
where many pass. No array of size N × M is held, only a block and the remaining pairs.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float64, Int32
from live.graph.build.metric import FlatClouds
from live.graph.build.metric_kernels import filter_block, pair_products

Complex = npt.NDArray[np.complex128]

MAX_PAIRS: Final = 16_000_000
"""Maximum edges of a graph: more would fill the memory (36 bytes each, twice during construction)."""
_BLOCK_PAIRS: Final = 1 << 21
"""Pairs of a block: about 24 MB in single precision."""
_TOLERANCE: Final = 4e-6
"""Error of the filter's squared distances as a share of the clouds' sizes: 30 times that of single precision."""
_DENSE_SHARE: Final = 0.1
"""If a larger share of a block passes, a full product in double precision is cheaper than single pairs."""
_MAX_UNFILTERED: Final = 1 << 16
"""Up to this many pairs are computed one by one, so that inserting a take does not start BLAS threads."""


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """E pairs of clouds (row of the first, row of the second), sorted by row, then column."""

    row: Int32
    column: Int32
    distance: Float64
    """Root of the weighted mean squared distance of the aligned clouds [m], shape (E,)."""
    motion: Float64
    """x, z [m] and yaw [rad] that bring the second cloud nearest to the first, shape (E, 3)."""


def near_pairs(first: FlatClouds, second: FlatClouds, threshold: float, codes: tuple[Int32, Int32]) -> Pairs:
    """Return pairs of `first` (N clouds) and `second` (M) within `threshold` [m] whose `codes` (N, 2), (M, 2) agree.

    Codes as in `structure_rules.StructureCodes`. ValueError if there are more than sixteen million.
    """
    if not (len(first) and len(second)):
        return Pairs(np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros(0), np.zeros((0, 3)))
    if len(first) * len(second) <= _MAX_UNFILTERED:
        row, column = (one.reshape(-1).astype(np.int32) for one in np.indices((len(first), len(second))))
        fits = _agree(codes[0][row], codes[1][column])
        row, column = row[fits], column[fits]
        return _within(first, second, row, column, threshold, *_pair_products(first, second, row, column))
    rows = max(1, _BLOCK_PAIRS // len(second))
    sieve = _PairFilter(first, second, threshold, codes, min(rows, len(first)))
    parts = []
    total = 0
    for begin in range(0, len(first), rows):
        part = sieve.block(begin, min(begin + rows, len(first)))
        parts.append(part)
        total += len(part.row)
        if total > MAX_PAIRS:
            raise ValueError(
                f"more than {MAX_PAIRS:,} pairs of measures are within {threshold:g} m of each other: "
                "lower the threshold, or leave measures out that are alike"
            )
    return Pairs(*(np.concatenate([getattr(part, name) for part in parts]) for name in Pairs.__slots__))


class _PairFilter:
    """The second clouds in single precision, and buffers for the pairs of one block of the first."""

    def __init__(
        self, first: FlatClouds, second: FlatClouds, threshold: float, codes: tuple[Int32, Int32], rows: int
    ) -> None:
        self._first, self._second, self._threshold, self._codes = first, second, threshold, codes
        self._floor = np.ascontiguousarray(second.coarse_floor.T)
        self._height = np.ascontiguousarray(second.coarse_height.T)
        self._out = np.zeros((2, rows * len(second)), np.int32)

    def block(self, begin: int, end: int) -> Pairs:
        """Return pairs of the rows `begin` to `end` (exclusive)."""
        a, b, part = self._first, self._second, slice(begin, end)
        count = filter_block(
            a.coarse_floor[part].conj() @ self._floor,
            a.coarse_height[part] @ self._height,
            a.coarse_size[part],
            b.coarse_size,
            self._threshold**2,
            _TOLERANCE,
            np.ascontiguousarray(self._codes[0][part]),
            self._codes[1],
            self._out[0],
            self._out[1],
        )
        row, column = self._out[0, :count].copy() + np.int32(begin), self._out[1, :count].copy()
        return _within(a, b, row, column, self._threshold, *self._exact(row, column, part))

    def _exact(self, row: Int32, column: Int32, part: slice) -> tuple[Complex, Float64]:
        a, b = self._first, self._second
        if len(row) > _DENSE_SHARE * (part.stop - part.start) * len(b):
            own = row - np.int32(part.start)
            product = (a.floor[part].conj() @ b.floor.T)[own, column]
            return product, (a.height[part] @ b.height.T)[own, column]
        return _pair_products(a, b, row, column)


def _agree(leaving: Int32, entering: Int32) -> Bool:
    """Return the same decision on codes as the filter kernel, for pairs (E, 2) and (E, 2)."""
    poses = (leaving[:, 0] == entering[:, 0]) | (leaving[:, 0] < 0) | (entering[:, 0] < 0)
    return np.asarray(poses & ~((leaving[:, 1] == entering[:, 1]) & (leaving[:, 1] >= 0)))


def _pair_products(a: FlatClouds, b: FlatClouds, row: Int32, column: Int32) -> tuple[Complex, Float64]:
    product, height = np.empty(len(row), np.complex128), np.empty(len(row))
    pair_products(a.floor, a.height, b.floor, b.height, row, column, product, height)
    return product, height


def _within(
    a: FlatClouds, b: FlatClouds, row: Int32, column: Int32, threshold: float, product: Complex, height: Float64
) -> Pairs:
    """Return those of the pairs (row, column) with these products that are within `threshold` [m]."""
    squared = a.size[row] + b.size[column] - 2.0 * np.abs(product) - 2.0 * height
    distance = np.sqrt(np.maximum(squared, 0.0))
    near = distance <= threshold
    if not near.all():
        row, column, distance, product = row[near], column[near], distance[near], product[near]
    return Pairs(row, column, distance, aligned(product, a.centre[row], b.centre[column]))


def aligned(product: Complex, centre_a: Complex, centre_b: Complex) -> Float64:
    """Return x, z [m] and yaw [rad] of K001 from products conj(a) · b (E,) and the clouds' centres, shape (E, 3)."""
    motion = np.empty((*product.shape, 3))
    motion[..., 2] = np.angle(product)
    # (x, z) turned by yaw is (x + iz) · exp(-i yaw), since yaw turns +z towards +x
    shift = centre_a - centre_b * np.exp(-1j * motion[..., 2])
    motion[..., 0], motion[..., 1] = shift.real, shift.imag
    return motion
