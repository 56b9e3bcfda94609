"""The thesis' sequence search, kept as a reference: modified depth-first search (T064)."""

from typing import TYPE_CHECKING, Final

import numpy as np

from live.base.arrays import Int32
from live.graph.search.sequence_spec import SequenceSpec

if TYPE_CHECKING:
    from live.graph.search.viterbi import Edges


NODE_BUDGET: Final = 1_000_000
"""Nodes visited before the search gives up: about a second."""


class SearchTooLong(ValueError):
    """The depth-first search gave up; its cost may grow exponentially with the measures."""


def depth_first(
    edges: "Edges",
    specification: SequenceSpec,
    *,
    start: int | None = None,
    budget: int = NODE_BUDGET,
    rejected: list[tuple[int, ...]] | None = None,
) -> Int32 | None:
    """Return the first dance without a wrong measure, as nodes (M,); None if there is none.

    The spanning tree of paths is searched in library order, from the beginnings of steps or after the node `start`; a
    branch is left at its first wrong measure. The search is complete, but may visit all paths: SearchTooLong after
    `budget` nodes. `rejected` receives the rejected paths, in order.
    """
    measures = specification.measures
    roots = np.flatnonzero(specification.enters) if start is None else _successors(edges, start)
    waiting = [list(roots[::-1])]
    path: list[int] = []
    looked_at = 0
    while waiting:
        if not waiting[-1]:
            waiting.pop()
            if path:
                path.pop()
            continue
        node = int(waiting[-1].pop())
        looked_at += 1
        if looked_at > budget:
            raise SearchTooLong(
                f"the depth-first search gave up after {budget} nodes, {len(path)} of {measures} measures deep: "
                "its cost can double with every measure; use the layered search"
            )
        last = len(path) == measures - 1
        if not specification.at(len(path))[node] or (last and not specification.leaves[node]):
            if rejected is not None:
                rejected.append((*path, node))
            continue
        if last:
            return np.array([*path, node], np.int32)
        path.append(node)
        waiting.append(list(_successors(edges, node)[::-1]))
    return None


def _successors(edges: "Edges", node: int) -> Int32:
    return np.asarray(edges.target[edges.start[node] : edges.start[node + 1]])
