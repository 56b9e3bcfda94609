"""Paths through the candidates: as many fragments as possible that follow each other in the data (P011-P013).

A join costs nothing where its two fragments were consecutive in the data, and 1 elsewhere. A path goes through some
of these free joins; wherever none leads on, it takes the closest match. The best have the fewest costs, and of these
those that are closer come first. That is the paper's way, `best_paths`. `weighed_paths` is our own: it adds up how far
matches are off and what joins cost, so that a long run of the data is left where it does not match any more.
"""

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field


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
