"""Up-sampling of a coarse reading: boundaries of the same units are searched again at the input's rate (H012).

The score (5) is the same, but the sequence of units is fixed. Each boundary is searched near its coarse position.
"""

from itertools import pairwise
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.motion.partner.decoder import Reading
from live.motion.partner.initial_search_kernels import fit_places, join_places
from live.motion.partner.point_clouds import Cloud, fit, gap, time_scaled
from live.motion.partner.time_scaled_units import legal_durations
from live.motion.partner.units import Units

SEARCH_RANGE: Final = 1.0
"""Search range of a boundary to both sides of its coarse position [frames of the coarse reading]."""


def refine(
    x: Cloud, units: Units, coarse: Reading, *, k: float, stretch: float, boundary_cost: Float64 | None = None
) -> Reading:
    """Return the units of `coarse` with the best boundaries for `x`, the same input at a higher rate.

    `k` is that of the coarse search. It is scaled with the rate here, because D sums over frames and C does not. The
    first and last boundary stay in place, or as near as the rates allow. `boundary_cost` (T,) is the extra cost of a
    boundary at each frame of `x`.
    """
    ratio = x.rate / coarse.rate
    edges = np.concatenate((coarse.start, coarse.start[-1:] + coarse.duration[-1:]))
    centre = np.minimum(np.round(edges * ratio).astype(np.int64), x.count - 1)
    if edges[-1] * ratio > x.count - 1 - ratio:
        centre[-1] = x.count - 1  # the coarse frames ended a little before the input did
    reach = np.full(len(centre), int(np.ceil(SEARCH_RANGE * ratio)))
    reach[0] = reach[-1] = 0
    low = np.maximum(centre - reach, 0)
    high = np.minimum(centre + reach, x.count - 1)
    legal = [legal_durations(float(units.seconds[unit]), x.rate, stretch) for unit in coarse.unit]
    for n in (0, -1):  # the ends are fixed by the input, up to rounding of the coarse frames
        legal[n] = range(max(legal[n].start - round(ratio), 1), legal[n].stop + round(ratio))
    tolls = np.zeros(x.count) if boundary_cost is None else boundary_cost
    return _search(x, units, coarse, k * ratio, low, high, legal, tolls)


def _search(
    x: Cloud,
    units: Units,
    coarse: Reading,
    k: float,
    low: Int64,
    high: Int64,
    legal: list[range],
    boundary_costs: Float64,
) -> Reading:
    """Search by dynamic programming over layers: one layer per unit, one cell per (begin, end)."""
    layers: list[tuple[Float64, Float64, Float64]] = []
    backs: list[Int64] = []
    before = np.zeros((0, 0))
    for n in range(coarse.count):
        of = units.examples[int(units.example[coarse.unit[n]])]
        shape = (int(high[n] - low[n]) + 1, int(high[n + 1] - low[n + 1]) + 1)
        found = np.full((*shape, 5), np.nan)  # D, turn, shift
        ends = np.zeros((2, *shape, 12))
        fit_places(
            x.floor, x.height, of.control.floor, of.control.height, of.target.floor, of.target.height,
            float(units.start[coarse.unit[n]]), float(units.length[coarse.unit[n]]), int(low[n]), int(low[n + 1]),
            legal[n].start, legal[n].stop - 1, found, ends[0], ends[1],
        )  # fmt: skip
        if not np.isfinite(found[..., 0]).any():
            return _keep_boundaries(x, units, coarse, k)
        score, back = np.full(shape, np.inf), np.full(shape, -1, np.int64)
        if n == 0:
            score = np.where(np.isfinite(found[..., 0]), found[..., 0], np.inf)
        else:
            join_places(before, layers[-1][1], found, ends[0], k, score, back)
        if n < coarse.count - 1:
            score += boundary_costs[int(low[n + 1]) : int(high[n + 1]) + 1]
        if not np.isfinite(score).any():
            return _keep_boundaries(x, units, coarse, k)
        layers.append((found, ends[1], ends[0]))
        backs.append(back)
        before = score
    return _backtrack(coarse, k, x.rate, low, before, layers, backs)


def _backtrack(
    coarse: Reading, k: float, rate: float, low: Int64, score: Float64,
    layers: list[tuple[Float64, Float64, Float64]], backs: list[Int64],
) -> Reading:  # fmt: skip
    begin, end = np.unravel_index(int(np.argmin(score)), score.shape)
    row: list[tuple[int, int]] = []
    for n in range(len(layers) - 1, -1, -1):
        row.append((int(begin), int(end)))
        end, begin = begin, backs[n][begin, end]
    row.reverse()
    place = [np.array([layer[at][one] for layer, one in zip(layers, row, strict=True)]) for at in range(3)]
    found, tail, head = place
    start = low[:-1] + np.array([one for one, _ in row])
    stop = low[1:] + np.array([other for _, other in row])
    gap = ((tail[:-1] - head[1:]) ** 2).sum(axis=1)
    total = float(found[:, 0].sum() + k * gap.sum())
    turn, shift = found[:, 1] + 1j * found[:, 2], found[:, 3] + 1j * found[:, 4]
    return Reading(coarse.unit, start, stop - start, turn, shift, found[:, 0], gap, total, rate)


def _keep_boundaries(x: Cloud, units: Units, coarse: Reading, k: float) -> Reading:
    """Return the coarse boundaries at the higher rate, for inputs where no legal boundaries lie near them."""
    ratio = x.rate / coarse.rate
    edges = np.concatenate((coarse.start, coarse.start[-1:] + coarse.duration[-1:]))
    edges = np.minimum(np.round(edges * ratio).astype(np.int64), x.count - 1)
    turn, shift, distance, targets = [], [], [], []
    for n, unit in enumerate(coarse.unit.tolist()):
        of = units.examples[int(units.example[unit])]
        begin, length, frames = float(units.start[unit]), float(units.length[unit]), int(edges[n + 1] - edges[n])
        window = Cloud(x.floor[edges[n] : edges[n + 1] + 1], x.height[edges[n] : edges[n + 1] + 1], x.rate)
        one = fit(window, time_scaled(of.control, begin, length, frames))
        turn.append(one.turn)
        shift.append(one.shift)
        distance.append(one.distance)
        targets.append(time_scaled(of.target, begin, length, frames).transformed(one.turn, one.shift))
    gaps = np.array([gap(one, other) for one, other in pairwise(targets)])
    score = float(np.sum(distance) + k * gaps.sum())
    return Reading(
        coarse.unit,
        edges[:-1],
        np.diff(edges),
        np.array(turn),
        np.array(shift),
        np.array(distance),
        gaps,
        score,
        x.rate,
    )
