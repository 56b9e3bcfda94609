"""The thesis' own search for a sequence, kept as a reference: modified depth-first search (T064)."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.graph.search.sequence_spec import Specification
from live.graph.search.viterbi import Edges

Int32 = npt.NDArray[np.int32]

BUDGET: Final = 1_000_000
"""Nodes looked at before the search gives up: about a second."""


class SearchTooLong(ValueError):
    """The depth-first search gave up: what it needs may grow exponentially with the measures."""


def depth_first(
    edges: Edges,
    specification: Specification,
    *,
    start: int | None = None,
    budget: int = BUDGET,
    rejected: list[tuple[int, ...]] | None = None,
) -> Int32 | None:
    """The first dance without a wrong measure, as nodes (M,); None if there is none.

    The spanning tree of paths is walked in the order of the library, from the beginnings of steps or after the node
    `start`, and a branch is left as soon as one of its measures is wrong. It is complete, but looks at up to as many
    paths as there are: SearchTooLong after `budget` nodes. `rejected` is given the paths that were left, in order.
    """
    measures = specification.measures
    roots = np.flatnonzero(specification.enters) if start is None else _followers(edges, start)
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
                "what it needs can double with every measure; the layered search does not"
            )
        last = len(path) == measures - 1
        if not specification.at(len(path))[node] or (last and not specification.leaves[node]):
            if rejected is not None:
                rejected.append((*path, node))
            continue
        if last:
            return np.array([*path, node], np.int32)
        path.append(node)
        waiting.append(list(_followers(edges, node)[::-1]))
    return None


def _followers(edges: Edges, node: int) -> Int32:
    return np.asarray(edges.target[edges.start[node] : edges.start[node + 1]])
