"""Offline search for the sequence of units that fits the input best with continuous targets (H006-H010).

All D and M of a block of boundaries come from matrix products (K003). They run in our own kernel, because the matrices
are too small for the threads of a BLAS library. The recurrence runs in a second kernel.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Complex128, Float64, Int64
from live.base.errors import PersonError
from live.motion.partner.decoder_kernels import SAMPLE_SIZE, multiply, propagate
from live.motion.partner.point_clouds import Cloud
from live.motion.partner.time_scaled_units import Stretches

BLOCK: Final = 128
"""Boundaries whose products are computed at once."""


@dataclass(frozen=True, slots=True, eq=False)
class Reading:
    """An input read as a sequence of L units."""

    unit: Int64
    """Index of each unit, (L,)."""
    start: Int64
    """Frame at which each begins, (L,)."""
    duration: Int64
    """Duration of each in frames, (L,): the next unit begins where it ends."""
    turn: Complex128
    """M of each: rotation about the vertical as a unit complex number, (L,)."""
    shift: Complex128
    """M of each: translation after the rotation [m], (L,)."""
    distance: Float64
    """D of each [m²], (L,)."""
    gap: Float64
    """C between each unit and the next [m²], (L - 1,)."""
    score: float
    """Sum of D and k C (5)."""
    rate: float
    """Frames per second [Hz]."""

    @property
    def count(self) -> int:
        """Number of units L."""
        return len(self.unit)


@dataclass(frozen=True, slots=True, eq=False)
class Products:
    """Products of the cells that begin at consecutive boundaries (U boundaries, P cells, G durations)."""

    product: Complex128
    """conj(a) · x of the centred clouds, (U, P)."""
    height_product: Float64
    """Product of the heights, (U, P)."""
    input_size: Float64
    """Sums of squares of the input's centred windows and of their heights, (U, G)."""
    input_middle: Complex128
    """Middles of the windows, (U, G)."""


def make_products(x: Cloud, stretches: Stretches, begin: int, stop: int) -> Products:
    """Compute the products of boundaries `begin` to `stop` - 1. Beyond the input's end its last frame is repeated."""
    points, cells, groups = x.floor.shape[1], stretches.count, len(stretches.groups)
    count, longest = stop - begin, int(stretches.duration[-1])
    rows = np.minimum(np.arange(begin, stop + longest), x.count - 1)
    floor, height = x.floor[rows], x.height[rows]
    origin = floor.mean()
    floor = floor - origin
    product, heights = np.empty((count, cells), np.complex128), np.empty((count, cells))
    size, middle = np.empty((count, groups)), np.empty((count, groups), np.complex128)
    sums = np.concatenate(([0.0], np.cumsum(floor.sum(axis=1))))
    squares = np.concatenate(([0.0], np.cumsum((np.abs(floor) ** 2 + height**2).sum(axis=1))))
    for n, (duration, first, _) in enumerate(stretches.groups):
        frames = duration + 1
        multiply(
            floor, height, frames, stretches.real[n], stretches.imaginary[n], stretches.control_height[n], first,
            product, heights,
        )  # fmt: skip
        at = np.arange(count)
        middle[:, n] = (sums[at + frames] - sums[at]) / (frames * points)
        size[:, n] = squares[at + frames] - squares[at] - frames * points * np.abs(middle[:, n]) ** 2
    return Products(product, heights, size, middle + origin)


def decode(
    x: Cloud,
    stretches: Stretches,
    *,
    k: float,
    beam: float = np.inf,
    free_start: int = 0,
    free_end: int = 0,
    boundary_cost: Float64 | None = None,
) -> Reading:
    """Return the reading of `x` (T frames at the rate of `stretches`) with the least score (5).

    `beam` [m²] keeps only cells whose score exceeds the best at their boundary by less (H010). The first unit may begin
    up to `free_start` frames after the input's start, the last may end up to `free_end` frames before its end. Frames
    left out cost nothing. `boundary_cost` (T,) is the extra cost of a boundary at each frame [m²]; it is infinite where
    no boundary is allowed (off the beat, if beats are known). Raises PersonError where no sequence of units is as long
    as the input.
    """
    last, cells = x.count - 1, stretches.count
    ring = int(stretches.duration[-1]) + 1
    ring_score = np.full((ring, cells), np.inf)
    ring_tail = np.zeros((ring, cells, SAMPLE_SIZE))
    back = np.full((last + 1, cells), -1, np.int32)
    tolls = np.zeros(x.count) if boundary_cost is None else np.ascontiguousarray(boundary_cost, np.float64)
    best, where = np.full(1, np.inf), np.full(2, -1, np.int64)
    group = np.repeat(np.arange(len(stretches.groups)), [stop - first for _, first, stop in stretches.groups])
    for begin in range(0, last + 1, BLOCK):
        made = make_products(x, stretches, begin, min(begin + BLOCK, last + 1))
        propagate(
            begin, last, free_start, free_end, k, beam, tolls, made.product, made.height_product, made.input_size,
            made.input_middle, group.astype(np.int64), stretches.duration, stretches.size, stretches.head,
            stretches.head_height, stretches.tail, stretches.tail_height, ring_score, ring_tail, back, best, where,
        )  # fmt: skip
    if where[1] < 0:
        shortest = float(stretches.duration[0]) / stretches.rate
        raise PersonError(
            f"no sequence of units is as long as the leader's {last / x.rate:.2f} s",
            f"the shortest unit is {shortest:.2f} s: give a longer motion, more units, or a larger --stretch",
        )
    cell, end = [], int(where[0])
    at, p = end, int(where[1])
    while p >= 0:
        cell.append(p)
        before = int(back[at, p])
        at -= int(stretches.duration[p])
        p = before
    return read_cells(x, stretches, np.array(cell[::-1], np.int64), at, k)


def read_cells(x: Cloud, stretches: Stretches, cell: Int64, start: int, k: float) -> Reading:
    """Return the reading of the consecutive cells (L,) from frame `start` on, with fits and costs."""
    duration = stretches.duration[cell]
    starts = start + np.concatenate(([0], np.cumsum(duration)[:-1]))
    turn, shift, distance = np.empty(len(cell), np.complex128), np.empty(len(cell), np.complex128), np.empty(len(cell))
    for n, p in enumerate(cell.tolist()):
        made = make_products(x, _single_cell(stretches, p), int(starts[n]), int(starts[n]) + 1)
        product, middle = complex(made.product[0, 0]), complex(made.input_middle[0, 0])
        turn[n] = product / abs(product) if abs(product) > 1e-12 else 1.0
        shift[n] = middle - turn[n] * stretches.middle[p]
        size = float(made.input_size[0, 0] + stretches.size[p])
        distance[n] = size - 2.0 * abs(product) - 2.0 * float(made.height_product[0, 0])
    place = turn[:, None], (shift + turn * stretches.middle[cell])[:, None]
    head, tail = place[0] * stretches.head[cell] + place[1], place[0] * stretches.tail[cell] + place[1]
    rise = stretches.tail_height[cell[:-1]] - stretches.head_height[cell[1:]]
    gap = (np.abs(tail[:-1] - head[1:]) ** 2).sum(axis=1) + (rise**2).sum(axis=1)
    score = float(distance.sum() + k * gap.sum())
    return Reading(stretches.unit[cell], starts, duration, turn, shift, distance, gap, score, stretches.rate)


def _single_cell(stretches: Stretches, cell: int) -> Stretches:
    """Return the stretches with only one cell."""
    index = int(np.searchsorted([stop for _, _, stop in stretches.groups], cell, side="right"))
    frames, first, _ = stretches.groups[index]
    one = slice(cell, cell + 1)
    column = slice(cell - first, cell - first + 1)
    return Stretches(
        stretches.units, stretches.rate, stretches.unit[one], stretches.duration[one], ((frames, 0, 1),),
        (np.ascontiguousarray(stretches.real[index][:, column]),),
        (np.ascontiguousarray(stretches.imaginary[index][:, column]),),
        (np.ascontiguousarray(stretches.control_height[index][:, column]),),
        stretches.size[one], stretches.head[one], stretches.head_height[one], stretches.tail[one],
        stretches.tail_height[one], stretches.middle[one],
    )  # fmt: skip
