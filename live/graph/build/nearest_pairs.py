"""The pairs of clouds that become edges, for libraries of any size (K003): within a threshold, and the nearest of each.

A recorded library has a thousand ways on from each measure, nearly all alike. A graph needs those that differ. Of each
node `EdgeLimits` keeps the nearest way into every step first, then into every variation of a step (side and direction
of travel), then the second nearest into each, and so on: variety before number. So a step that could follow directly
still can, and a dancer still finds a way in every direction. Of each node also the nearest ways *into* it are kept, so
that none is left out because better ones lie beside it. What the whole graph connects and these edges do not is
connected by links (`find_joins`).

The rule needs no memory of what it left out: an edge that it refuses among some nodes it refuses among more. So nodes
can be inserted later with the same result.

Blocks of rows pass a filter in single precision: one complex and one real matrix product of coarse clouds (parabolas in
time, a quarter of the numbers). Coarse clouds are never farther apart than the clouds themselves, so only pairs that
may be among the nearest are computed in double precision, and tested for the blend. No array of size N × M is held.
"""

from dataclasses import dataclass, fields
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Complex64, Float32, Float64, Int32
from live.graph.build.blend_feasibility import MIN_CHORD, MIN_ROOT_COSINE, Blends
from live.graph.build.metric import FlatClouds
from live.graph.build.metric_kernels import keep_nearest, nearest_in_block

Complex = npt.NDArray[np.complex128]

_BLOCK_PAIRS: Final = 1 << 20
"""Pairs of a block: about 12 MB in single precision."""
_TOLERANCE: Final = 4e-6
"""Error of the filter's squared distances as a share of the clouds' sizes: 30 times that of single precision."""
_MAX_PLAIN: Final = 1 << 16
"""Up to this many pairs are multiplied without BLAS, so that inserting a take does not start its threads."""
_BUFFER: Final = 1 << 15
"""Pairs that the kernel returns at a time."""


@dataclass(frozen=True, slots=True)
class EdgeLimits:
    """How many edges a graph keeps. Sketched steps, of which there are few, keep all that are within the threshold."""

    per_node: int = 384
    """Edges out of a node: the nearest step of each name first, then of each variation, then the second nearest ..."""
    per_variation: int = 12
    """Edges from a node into one variation of a step: its side and direction of travel."""
    into: int = 2
    """The nearest edges into each node, which are kept in any case."""


ALL_EDGES: Final = EdgeLimits(1 << 30, 1 << 30, 0)
"""No limits: every pair within the threshold."""


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """E pairs of clouds (row of the first, row of the second), sorted by row, then column."""

    row: Int32
    column: Int32
    distance: Float64
    """Root of the weighted mean squared distance of the aligned clouds [m], shape (E,)."""
    motion: Float64
    """x, z [m] and yaw [rad] that bring the second cloud nearest to the first, shape (E, 3)."""


@dataclass(frozen=True, slots=True, eq=False)
class PairCodes:
    """What decides, besides the distance, which of N clouds may be followed by which of M, and which are kept."""

    leaving: Int32
    """See `structure_rules.StructureCodes`, (N, 2)."""
    entering: Int32
    """(M, 2)."""
    step: Int32
    """Step of each second cloud, (M,)."""
    variation: Int32
    """Variation of its step, (M,)."""
    apart: tuple[Int32, Int32] | None = None
    """Codes (N,) and (M,) that must differ in a pair, if both are 0 or more."""

    @classmethod
    def free(cls, first: int, second: int) -> "PairCodes":
        """Codes with which each of `first` clouds may be followed by each of `second`, all of one step."""
        one = np.zeros(second, np.int32)
        return cls(np.full((first, 2), -1, np.int32), np.full((second, 2), -1, np.int32), one, one)


def near_pairs(
    first: FlatClouds,
    second: FlatClouds,
    threshold: float,
    codes: PairCodes,
    limits: EdgeLimits = ALL_EDGES,
    blends: Blends | None = None,
) -> Pairs:
    """Return the pairs of `first` (N clouds) and `second` (M) within `threshold` [m] that `limits` keep.

    `codes` must allow them; with `blends` they must be blendable, too.
    """
    if not (len(first) and len(second)):
        return Pairs(np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros(0), np.zeros((0, 3)))
    near = _search(
        first, second, threshold, codes, limits, Blends.none(len(first), len(second)) if blends is None else blends
    )
    order = np.argsort(near.row.astype(np.int64) * len(second) + near.column)
    near = near.select(order)
    near = near.select(
        kept_edges(near.row, near.column, near.distance, codes.step, codes.variation, len(first), limits)
    )
    motion = aligned(near.product, first.centre[near.row], second.centre[near.column])
    return Pairs(near.row, near.column, near.distance, motion)


def kept_edges(
    row: Int32, column: Int32, distance: Float64, step: Int32, variation: Int32, rows: int, limits: EdgeLimits
) -> Bool:
    """Return which of E pairs, sorted by row (below `rows`), then column, `limits` keep, (E,).

    `step` and `variation` (M,) of each column. A pair that is refused among these is refused among more.
    """
    out = np.zeros(len(row), np.bool_)
    first = np.searchsorted(row, np.arange(rows + 1)).astype(np.int64)
    most = min(limits.per_variation, len(variation))
    keep_nearest(
        first, column, distance, np.lexsort((distance, row)), _compact(variation), _compact(step), limits.per_node,
        most, limits.into, out,
    )  # fmt: skip
    return out


def _compact(codes: Int32) -> Int32:
    """Return codes (M,) as numbers from 0 without gaps, so that none is as large as M."""
    return np.asarray(np.unique(codes, return_inverse=True)[1], np.int32)


@dataclass(frozen=True, slots=True, eq=False)
class _Near:
    """Pairs with the products of their clouds, in no order."""

    row: Int32
    column: Int32
    distance: Float64
    product: Complex

    @classmethod
    def empty(cls, count: int) -> "_Near":
        return cls(
            np.empty(count, np.int32), np.empty(count, np.int32), np.empty(count), np.empty(count, np.complex128)
        )

    @classmethod
    def joined(cls, parts: list["_Near"]) -> "_Near":
        return cls(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(cls)))

    def select(self, index: npt.NDArray[np.integer] | Bool | slice) -> "_Near":
        return _Near(*(getattr(self, field.name)[index] for field in fields(_Near)))


def _search(
    first: FlatClouds, second: FlatClouds, threshold: float, codes: PairCodes, limits: EdgeLimits, blends: Blends
) -> _Near:
    """Return all pairs that `limits` may keep, and some others."""
    count = len(second)
    apart = (np.full(len(first), -1, np.int32), np.full(count, -1, np.int32)) if codes.apart is None else codes.apart
    variation = _compact(codes.variation)
    ranked = np.empty((int(variation.max()) + 1, min(limits.per_variation, count)))
    into = np.full((count, limits.into), np.inf)
    worst = np.full(count, np.inf if limits.into else -1.0)
    parts = [_Near.empty(0)]
    buffer = _Near.empty(max(_BUFFER, count))
    rows = max(1, _BLOCK_PAIRS // count)
    for begin in range(0, len(first), rows):
        own = slice(begin, min(begin + rows, len(first)))
        product, height = _coarse_products(first, second, own)
        done = 0
        while done < len(product):
            done, found = nearest_in_block(
                done, product, height, first.coarse_size[own], second.coarse_size, threshold, _TOLERANCE,
                np.ascontiguousarray(codes.leaving[own]), codes.entering, variation, apart[0][own], apart[1],
                limits.per_node, first.floor[own], first.height[own], first.size[own], second.floor, second.height,
                second.size, blends.end[own], blends.start, blends.weight, blends.end_stands[own], blends.start_stands,
                MIN_ROOT_COSINE, MIN_CHORD,
                ranked, np.zeros(len(ranked), np.int32), into, worst,
                buffer.row, buffer.column, buffer.distance, buffer.product,
            )  # fmt: skip
            part = buffer.select(slice(0, found))
            parts.append(
                _Near(part.row + np.int32(begin), part.column.copy(), part.distance.copy(), part.product.copy())
            )
    return _Near.joined(parts)


def _coarse_products(first: FlatClouds, second: FlatClouds, own: slice) -> tuple[Complex64, Float32]:
    floor, height = first.coarse_floor[own].conj(), first.coarse_height[own]
    if len(floor) * len(second) <= _MAX_PLAIN:
        return np.einsum("ip,jp->ij", floor, second.coarse_floor), np.einsum("ip,jp->ij", height, second.coarse_height)
    return floor @ second.coarse_floor.T, height @ second.coarse_height.T


def aligned(product: Complex, centre_a: Complex, centre_b: Complex) -> Float64:
    """Return x, z [m] and yaw [rad] of K001 from products conj(a) · b (E,) and the clouds' centres, shape (E, 3)."""
    motion = np.empty((*product.shape, 3))
    motion[..., 2] = np.angle(product)
    # (x, z) turned by yaw is (x + iz) · exp(-i yaw), since yaw turns +z towards +x
    shift = centre_a - centre_b * np.exp(-1j * motion[..., 2])
    motion[..., 0], motion[..., 1] = shift.real, shift.imag
    return motion
