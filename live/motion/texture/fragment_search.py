"""Matching: which fragments of the data are most like one of the sketch's (P007-P010).

Paths through the candidates: as many fragments as possible that follow each other in the data (P011-P013).

A join costs nothing where its two fragments were consecutive in the data, and 1 elsewhere. A path goes through some
of these free joins; wherever none leads on, it takes the closest match. The best have the fewest costs, and of these
those that are closer come first. That is the paper's way, `best_paths`. `weighed_paths` is our own: it adds up how far
matches are off and what joins cost, so that a long run of the data is left where it does not match any more.
"""

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.texture.fragments import Fragments

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

LONGEST: Final = 4.0
"""A fragment of the data that lasts longer than so many times the sketch's is rejected: poses held for calibration."""
SHARE: Final = 0.1
"""Of all fragments so many are kept as candidates (K)."""
SCALES: Final = (0.0, 2.0)
"""Within this the scale of P010 is looked for: the paper bounds it not, and a negative one would turn motion about."""


@dataclass(frozen=True, slots=True, eq=False)
class Matches:
    """The candidates of each of n fragments of the sketch, the closest first."""

    candidates: tuple[Int64, ...]
    """For each the fragments of the data, (at most K,)."""
    distances: tuple[Float64, ...]
    """The mean square of what differs, value and derivative, of each, in the features' own units."""
    scales: tuple[Float64, ...]
    """The scale of each (P010); 1 where none was asked for."""


def resampled(signal: Float64, begin: Int64, end: Int64, count: int) -> Float64:
    """Fragments of `signal` (T, D) from samples `begin` to `end` (F,) by linear resampling to `count` samples,
    (F, count, D)."""
    part = np.linspace(0.0, 1.0, count)
    at = begin[:, None] + (end - begin)[:, None] * part
    low = np.minimum(at.astype(np.int64), len(signal) - 2)
    weight = (at - low)[..., None]
    return np.asarray(signal[low] * (1.0 - weight) + signal[low + 1] * weight)


def match(
    sketch: Float64, sketch_parts: Fragments, data: Float64, data_parts: Fragments, keep: int, *, scale: bool = False
) -> Matches:
    """The `keep` (K) fragments of the data that are most like each of the sketch's.

    `sketch` (T, 2 D) and `data` (S, 2 D) hold the D matching angles' band and behind it the derivatives, weighted.
    Raises ValueError where every fragment of the data is too long for one of the sketch.
    """
    count = sketch_parts.count
    candidates = [np.zeros(0, np.int64)] * count
    distances, scales = ([np.zeros(0)] * count for _ in range(2))
    lengths = sketch_parts.length
    for length in np.unique(lengths).tolist():
        allowed = np.flatnonzero(data_parts.length <= LONGEST * length)
        if not len(allowed):
            raise ValueError(f"all fragments of the data last longer than {LONGEST:g} times {length} samples")
        theirs = resampled(data, data_parts.begin[allowed], data_parts.end[allowed], length + 1)
        flat = theirs.reshape(len(allowed), -1)
        own_rows = np.flatnonzero(lengths == length)
        own = resampled(sketch, sketch_parts.begin[own_rows], sketch_parts.end[own_rows], length + 1)
        own = own.reshape(len(own_rows), -1)
        apart = _squares(own, flat) / flat.shape[1]
        for row, far in zip(own_rows.tolist(), apart, strict=True):
            best = np.argsort(far, kind="stable")[:keep]
            candidates[row], distances[row] = allowed[best], far[best]
            scales[row] = np.ones(len(best))
            if scale:
                half = sketch.shape[1] // 2
                mine = sketch[sketch_parts.begin[row] : sketch_parts.end[row] + 1, :half]
                scales[row] = _scales(mine, theirs[best][..., :half])
    return Matches(tuple(candidates), tuple(distances), tuple(scales))


def _squares(a: Float64, b: Float64) -> Float64:
    """Squared distances (n, m) of rows (n, d) and (m, d)."""
    squares = np.sum(a * a, axis=1)[:, None] + np.sum(b * b, axis=1)[None] - 2.0 * (a @ b.T)
    return np.asarray(np.maximum(squares, 0.0))


def _scales(own: Float64, theirs: Float64) -> Float64:
    """The scale s of each of `theirs` (K, n, D) for which ‖s M - A‖ is least (P010): <M, A> / <M, M>, within SCALES."""
    over = np.einsum("knd,nd->k", theirs, own)
    under = np.einsum("knd,knd->k", theirs, theirs)
    return np.asarray(np.clip(np.where(under > 1e-12, over / np.maximum(under, 1e-12), 1.0), *SCALES))


@dataclass(order=True, slots=True)
class _Partial:
    """A path as far as it has come: a linked list from its end."""

    cost: int
    distance: float
    row: tuple[int, ...] = field(default=())
    """Places of the candidates so far: breaks ties, the closer first."""


@dataclass(frozen=True, slots=True)
class Path:
    """One way through the candidates of n fragments."""

    places: tuple[int, ...]
    """Which of its candidates each takes, 0 for the closest, (n,)."""
    free: int
    """Joins of fragments that were consecutive in the data."""
    distance: float
    """Sum of the distances of what is taken."""


def best_paths(
    candidates: Sequence[Sequence[int]],
    distances: Sequence[Sequence[float]],
    follows: Callable[[int, int], bool],
    most: int,
) -> list[Path]:
    """The best `most` (P) paths, or all if there are fewer.

    `candidates[i]` are the fragments of the data that match the i-th of the sketch, the closest first, and
    `follows(a, b)` says whether b comes right after a in the data. A candidate that is not the closest is taken only
    where a free join leads to it or on from it.
    """
    # two kinds of ends: those to which a free join led, or that are the closest, may go anywhere; the others must go on
    # by a free join
    free_ends, bound_ends = _first(candidates[0], distances[0])
    for index in range(1, len(candidates)):
        before, after = candidates[index - 1], candidates[index]
        place_of = {fragment: place for place, fragment in enumerate(after)}
        next_of = {
            place: place_of[fragment + 1]
            for place, fragment in enumerate(before)
            if fragment + 1 in place_of and follows(fragment, fragment + 1)
        }
        from_of = {then: place for place, then in next_of.items()}
        anywhere = heapq.nsmallest(2 * most, (one for ends in free_ends.values() for one in ends))
        free: dict[int, list[_Partial]] = {}
        bound: dict[int, list[_Partial]] = {}
        goes_on = _going_on(after, candidates[index + 1] if index + 1 < len(candidates) else (), follows)
        for place in {0, *from_of, *goes_on}:
            far = float(distances[index][place])
            came = from_of.get(place, -1)
            linked = [
                _Partial(p.cost, p.distance + far, (*p.row, place))
                for p in (*free_ends.get(came, ()), *bound_ends.get(came, ()))
            ]
            paid = [p for p in anywhere if p.row[-1] != came][:most]
            bought = [_Partial(p.cost + 1, p.distance + far, (*p.row, place)) for p in paid]
            if place == 0:
                free[place] = heapq.nsmallest(most, linked + bought)
            else:
                free[place] = heapq.nsmallest(most, linked)
                bound[place] = heapq.nsmallest(most, bought) if place in goes_on else []
        free_ends, bound_ends = free, bound
    found = heapq.nsmallest(most, (one for ends in free_ends.values() for one in ends))
    joins = len(candidates) - 1
    return [Path(one.row, joins - one.cost, one.distance) for one in found]


def weighed_paths(
    candidates: Sequence[Sequence[int]],
    distances: Sequence[Sequence[float]],
    follows: Callable[[int, int], bool],
    most: int,
    join: float,
) -> list[Path]:
    """The `most` paths with the least sum of distances and joins, each join that was none in the data at `join`."""
    ends = {place: [_Partial(0, float(far), (place,))] for place, far in enumerate(distances[0])}
    for index in range(1, len(candidates)):
        place_of = {fragment: place for place, fragment in enumerate(candidates[index - 1])}
        anywhere = heapq.nsmallest(2 * most, (one for some in ends.values() for one in some), key=_sum)
        after: dict[int, list[_Partial]] = {}
        for place, fragment in enumerate(candidates[index]):
            far, came = float(distances[index][place]), place_of.get(fragment - 1, -1)
            if came >= 0 and not follows(fragment - 1, fragment):
                came = -1
            on = [_Partial(p.cost, p.distance + far, (*p.row, place)) for p in ends.get(came, ())]
            paid = [p for p in anywhere if p.row[-1] != came][:most]
            on += [_Partial(p.cost + 1, p.distance + far + join, (*p.row, place)) for p in paid]
            after[place] = heapq.nsmallest(most, on, key=_sum)
        ends = after
    found = heapq.nsmallest(most, (one for some in ends.values() for one in some), key=_sum)
    joins = len(candidates) - 1
    return [Path(one.row, joins - one.cost, one.distance - one.cost * join) for one in found]


def _sum(one: _Partial) -> tuple[float, tuple[int, ...]]:
    return one.distance, one.row


def _first(
    candidates: Sequence[int], distances: Sequence[float]
) -> tuple[dict[int, list[_Partial]], dict[int, list[_Partial]]]:
    ends = {place: [_Partial(0, float(distances[place]), (place,))] for place in range(len(candidates))}
    return {0: ends.pop(0)}, ends


def _going_on(own: Sequence[int], then: Sequence[int], follows: Callable[[int, int], bool]) -> set[int]:
    """Places in `own` from which a free join leads into `then`."""
    there = set(then)
    return {place for place, one in enumerate(own) if one + 1 in there and follows(one, one + 1)}
