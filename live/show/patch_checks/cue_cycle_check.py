"""Detection of cycles among cues, through calls, signals and `then = "auto"`, before a show runs."""

import heapq
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

from live.show.patch.patch import Patch
from live.show.patch.section_cues import CueSection

CUE: Final = "/dance/cue"
SIGNAL: Final = "/dance/signal"
Node = int | str
"""A cue, by its index, or a signal, by its folded name."""
Edges = dict[Node, list[tuple[float, Node]]]
"""For each node the nodes that it triggers, with the least number of beats in between."""


@dataclass(frozen=True, slots=True)
class CueLoop:
    """A cue that triggers itself, directly or through others."""

    cue: int
    """Its index in the patch."""
    direct: bool
    """Whether it calls itself directly."""
    min_beats: float
    """Least number of beats until it comes again."""
    key_path: tuple[str | int, ...]
    """The keys of the call that begins the loop."""


def cue_loops(patch: Patch, within: float = math.inf) -> Iterator[CueLoop]:
    """Yield the loops that take at most `within` beats; of loops that share cues, only the first one found."""
    names = cue_index_by_name(patch.cue)
    for index, cue in enumerate(patch.cue):
        for row, call in enumerate(cue.calls):
            if _call_target(call, names) == index:
                wait = _least_wait(cue, patch.clock.beats_per_measure)
                yield CueLoop(index, True, wait, ("cue", index, "calls", row))
    ways = _cyclic_edges(_trigger_edges(patch))
    told: set[Node] = set()
    for index, cue in enumerate(patch.cue):
        if index in told or index not in ways:
            continue
        for row, call in enumerate(cue.calls):
            there = _call_target(call, names)
            if there is None or there == index or there not in ways:
                continue
            first = 0.0 if isinstance(there, str) else _least_wait(patch.cue[there], patch.clock.beats_per_measure)
            beats, path = _shortest_path(ways, there, index, within - first)
            if path:
                told |= set(path)
                yield CueLoop(index, False, first + beats, ("cue", index, "calls", row))
                break


def cue_index_by_name(cues: Sequence[CueSection]) -> dict[str, int]:
    """Index of each cue by number and by folded name; the first one wins."""
    names: dict[str, int] = {}
    for index, cue in enumerate(cues):
        names.setdefault(_folded(cue.name), index)
        if cue.number is not None:
            names.setdefault(f"{cue.number:g}", index)
    return names


def _call_target(call: Sequence[Any], names: dict[str, int]) -> Node | None:
    """The cue or signal that a call triggers; None for any other call."""
    if len(call) < 2 or call[0] not in (CUE, SIGNAL):
        return None
    name = _folded(str(call[1]))
    return name if call[0] == SIGNAL else names.get(name)


def _least_wait(cue: CueSection, beats: int) -> float:
    """Least number of beats before a cue happens that was called at the point of its last run."""
    least = {"now": 0.0, "beat": 1.0}.get(cue.when, float(beats))
    return max(cue.count_in, least)


def _trigger_edges(patch: Patch) -> Edges:
    """All edges between cues, with signals as nodes in between."""
    beats, names = patch.clock.beats_per_measure, cue_index_by_name(patch.cue)
    ways: Edges = {}

    def lead(begins: Node, after: float, there: Node | None) -> None:
        if there is not None:
            wait = 0.0 if isinstance(there, str) else _least_wait(patch.cue[there], beats)
            ways.setdefault(begins, []).append((after + wait, there))

    for index, cue in enumerate(patch.cue):
        for call in cue.calls:
            lead(index, 0.0, _call_target(call, names))
        if cue.then == "auto" and index + 1 < len(patch.cue):
            ways.setdefault(index, []).append((float((cue.after or 1) * beats), index + 1))
    for reaction in patch.react:
        if reaction.on is not None and reaction.call is not None:
            after = {"now": 0.0, "beat": 1.0}.get(reaction.when, float(beats))
            lead(_folded(reaction.on), after, _call_target((reaction.call, *reaction.values), names))
    return ways


def _cyclic_edges(ways: Edges) -> Edges:
    """The edges without the nodes that no cycle leads to; empty for most patches."""
    into = Counter(there for leads in ways.values() for _, there in leads)
    left = dict(ways)
    first = [here for here in ways if not into[here]]
    while first:
        for _, there in left.pop(first.pop(), ()):
            into[there] -= 1
            if not into[there]:
                first.append(there)
    return left


def _shortest_path(ways: Edges, begins: Node, end: Node, within: float) -> tuple[float, list[Node]]:
    """Least beats between two nodes, and the path (Dijkstra); an empty path if all take more than `within` beats."""
    before: dict[Node, Node | None] = {}
    coming: list[tuple[float, int, Node, Node | None]] = [(0.0, 0, begins, None)]
    count = 0
    while coming:
        beats, _, here, last = heapq.heappop(coming)
        if beats > within:
            break
        if here in before:
            continue
        before[here] = last
        if here == end:
            path = [here]
            while (step := before[path[-1]]) is not None:
                path.append(step)
            return beats, path
        for after, there in ways.get(here, ()):
            count += 1
            heapq.heappush(coming, (beats + after, count, there, here))
    return math.inf, []


def _folded(name: str) -> str:
    return name.casefold().strip()
