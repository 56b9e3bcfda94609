"""Search for the fragments of the data that are most like the sketch's, and for paths through them (P007-P013).

A join costs 0 where its two fragments are consecutive in the data (a free join), and 1 elsewhere. `best_paths` is the
paper's method (P011-P013): a path follows free joins and otherwise takes the closest match; the fewest costs win, then
the smallest distance. `weighted_paths` is our addition: it minimizes the sum of match distances and join costs, so a
long run of the data is left where it no longer matches.
"""

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.motion.texture.fragments import Fragments

MAX_LENGTH_RATIO: Final = 4.0
"""A fragment of the data longer than this many times the sketch's is rejected: poses held for calibration."""
CANDIDATE_SHARE: Final = 0.1
"""Share of all fragments kept as candidates (K)."""
SCALE_RANGE: Final = (0.0, 2.0)
"""Range of the scale of P010. The paper does not bound it; a negative scale would reverse the motion."""


@dataclass(frozen=True, slots=True, eq=False)
class Matches:
    """The candidates of each of n fragments of the sketch, the closest first."""

    candidates: tuple[Int64, ...]
    """For each the indices of fragments of the data, (at most K,)."""
    distances: tuple[Float64, ...]
    """Mean squared difference of values and derivatives of each, in the features' units."""
    scales: tuple[Float64, ...]
    """The scale of each (P010); 1 where scaling is off."""


def resample_fragments(signal: Float64, begin: Int64, end: Int64, count: int) -> Float64:
    """Return the fragments of `signal` (T, D) from samples `begin` to `end` (F,), (F, count, D).

    Each is resampled linearly to `count` samples.
    """
    part = np.linspace(0.0, 1.0, count)
    at = begin[:, None] + (end - begin)[:, None] * part
    low = np.minimum(at.astype(np.int64), len(signal) - 2)
    weight = (at - low)[..., None]
    return np.asarray(signal[low] * (1.0 - weight) + signal[low + 1] * weight)


def match_fragments(
    sketch: Float64, sketch_parts: Fragments, data: Float64, data_parts: Fragments, keep: int, *, scale: bool = False
) -> Matches:
    """Return the `keep` (K) fragments of the data that are most like each of the sketch's.

    `sketch` (T, 2 D) and `data` (S, 2 D) hold one band of the D matching angles, then their weighted derivatives.
    Raises ValueError where every fragment of the data is too long for one of the sketch.
    """
    count = sketch_parts.count
    candidates = [np.zeros(0, np.int64)] * count
    distances, scales = ([np.zeros(0)] * count for _ in range(2))
    lengths = sketch_parts.length
    for length in np.unique(lengths).tolist():
        allowed = np.flatnonzero(data_parts.length <= MAX_LENGTH_RATIO * length)
        if not len(allowed):
            raise ValueError(f"all fragments of the data last longer than {MAX_LENGTH_RATIO:g} times {length} samples")
        theirs = resample_fragments(data, data_parts.begin[allowed], data_parts.end[allowed], length + 1)
        flat = theirs.reshape(len(allowed), -1)
        own_rows = np.flatnonzero(lengths == length)
        own = resample_fragments(sketch, sketch_parts.begin[own_rows], sketch_parts.end[own_rows], length + 1)
        own = own.reshape(len(own_rows), -1)
        apart = squared_distances(own, flat) / flat.shape[1]
        for row, far in zip(own_rows.tolist(), apart, strict=True):
            best = np.argsort(far, kind="stable")[:keep]
            candidates[row], distances[row] = allowed[best], far[best]
            scales[row] = np.ones(len(best))
            if scale:
                half = sketch.shape[1] // 2
                mine = sketch[sketch_parts.begin[row] : sketch_parts.end[row] + 1, :half]
                scales[row] = _scales(mine, theirs[best][..., :half])
    return Matches(tuple(candidates), tuple(distances), tuple(scales))


def squared_distances(a: Float64, b: Float64) -> Float64:
    """Return the squared distances (n, m) of rows (n, d) and (m, d)."""
    squares = np.sum(a * a, axis=1)[:, None] + np.sum(b * b, axis=1)[None] - 2.0 * (a @ b.T)
    return np.asarray(np.maximum(squares, 0.0))


def _scales(own: Float64, theirs: Float64) -> Float64:
    """Return for each of `theirs` (K, n, D) the scale s that minimizes ‖s M - A‖ (P010), <M, A> / <M, M>, in SCALES."""
    over = np.einsum("knd,nd->k", theirs, own)
    under = np.einsum("knd,knd->k", theirs, theirs)
    return np.asarray(np.clip(np.where(under > 1e-12, over / np.maximum(under, 1e-12), 1.0), *SCALE_RANGE))


@dataclass(order=True, slots=True)
class _Partial:
    """A partial path, up to the current fragment."""

    cost: int
    distance: float
    ranks: tuple[int, ...] = field(default=())
    """Ranks of the candidates so far; breaks ties in favour of the closer."""


@dataclass(frozen=True, slots=True)
class Path:
    """One path through the candidates of n fragments."""

    ranks: tuple[int, ...]
    """Rank of the candidate chosen for each fragment, 0 for the closest, (n,)."""
    consecutive_joins: int
    """Number of joins of fragments that are consecutive in the data."""
    distance: float
    """Sum of the distances of the chosen candidates."""


def best_paths(
    candidates: Sequence[Sequence[int]],
    distances: Sequence[Sequence[float]],
    follows: Callable[[int, int], bool],
    max_paths: int,
) -> list[Path]:
    """Return the best `max_paths` (P) paths, or all if there are fewer.

    `candidates[i]` are the fragments of the data that match the i-th of the sketch, the closest first.
    `follows(a, b)` tells whether b comes right after a in the data. A candidate other than the closest is chosen only
    where a free join leads to it or from it.
    """
    # Two kinds of ends: those reached by a free join, and the closest matches, may continue anywhere. The others must
    # continue by a free join.
    free_ends, bound_ends = _initial_ends(candidates[0], distances[0])
    for index in range(1, len(candidates)):
        before, after = candidates[index - 1], candidates[index]
        place_of = {fragment: place for place, fragment in enumerate(after)}
        next_of = {
            place: place_of[fragment + 1]
            for place, fragment in enumerate(before)
            if fragment + 1 in place_of and follows(fragment, fragment + 1)
        }
        from_of = {then: place for place, then in next_of.items()}
        anywhere = heapq.nsmallest(2 * max_paths, (one for ends in free_ends.values() for one in ends))
        free: dict[int, list[_Partial]] = {}
        bound: dict[int, list[_Partial]] = {}
        goes_on = _continuing_ranks(after, candidates[index + 1] if index + 1 < len(candidates) else (), follows)
        for place in {0, *from_of, *goes_on}:
            far = float(distances[index][place])
            came = from_of.get(place, -1)
            linked = [
                _Partial(p.cost, p.distance + far, (*p.ranks, place))
                for p in (*free_ends.get(came, ()), *bound_ends.get(came, ()))
            ]
            paid = [p for p in anywhere if p.ranks[-1] != came][:max_paths]
            bought = [_Partial(p.cost + 1, p.distance + far, (*p.ranks, place)) for p in paid]
            if place == 0:
                free[place] = heapq.nsmallest(max_paths, linked + bought)
            else:
                free[place] = heapq.nsmallest(max_paths, linked)
                bound[place] = heapq.nsmallest(max_paths, bought) if place in goes_on else []
        free_ends, bound_ends = free, bound
    found = heapq.nsmallest(max_paths, (one for ends in free_ends.values() for one in ends))
    joins = len(candidates) - 1
    return [Path(one.ranks, joins - one.cost, one.distance) for one in found]


def weighted_paths(
    candidates: Sequence[Sequence[int]],
    distances: Sequence[Sequence[float]],
    follows: Callable[[int, int], bool],
    max_paths: int,
    join_cost: float,
) -> list[Path]:
    """Return the `max_paths` paths with the least sum of distances and joins, of `join_cost` each unless free."""
    ends = {place: [_Partial(0, float(far), (place,))] for place, far in enumerate(distances[0])}
    for index in range(1, len(candidates)):
        place_of = {fragment: place for place, fragment in enumerate(candidates[index - 1])}
        anywhere = heapq.nsmallest(2 * max_paths, (one for some in ends.values() for one in some), key=_sum)
        after: dict[int, list[_Partial]] = {}
        for place, fragment in enumerate(candidates[index]):
            far, came = float(distances[index][place]), place_of.get(fragment - 1, -1)
            if came >= 0 and not follows(fragment - 1, fragment):
                came = -1
            on = [_Partial(p.cost, p.distance + far, (*p.ranks, place)) for p in ends.get(came, ())]
            paid = [p for p in anywhere if p.ranks[-1] != came][:max_paths]
            on += [_Partial(p.cost + 1, p.distance + far + join_cost, (*p.ranks, place)) for p in paid]
            after[place] = heapq.nsmallest(max_paths, on, key=_sum)
        ends = after
    found = heapq.nsmallest(max_paths, (one for some in ends.values() for one in some), key=_sum)
    joins = len(candidates) - 1
    return [Path(one.ranks, joins - one.cost, one.distance - one.cost * join_cost) for one in found]


def _sum(one: _Partial) -> tuple[float, tuple[int, ...]]:
    return one.distance, one.ranks


def _initial_ends(
    candidates: Sequence[int], distances: Sequence[float]
) -> tuple[dict[int, list[_Partial]], dict[int, list[_Partial]]]:
    ends = {place: [_Partial(0, float(distances[place]), (place,))] for place in range(len(candidates))}
    return {0: ends.pop(0)}, ends


def _continuing_ranks(own: Sequence[int], then: Sequence[int], follows: Callable[[int, int], bool]) -> set[int]:
    """Return the ranks in `own` from which a free join leads into `then`."""
    there = set(then)
    return {place for place, one in enumerate(own) if one + 1 in there and follows(one, one + 1)}
