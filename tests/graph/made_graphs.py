"""Random graphs for tests of the searches: steps of 1, 2 and 4 measures, edges between their ends."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from live.graph.search.sequence_spec import SequenceEntry, SequenceSpec
from live.graph.search.viterbi import Edges


@dataclass(frozen=True)
class MadeGraph:
    """Nodes and edges, as plain lists beside the arrays of the searches."""

    edges: Edges
    step: list[int]
    measure: list[int]
    length: list[int]

    def follows(self, node: int) -> dict[int, float]:
        """The successors of a node with the cost of each edge."""
        row = range(self.edges.start[node], self.edges.start[node + 1])
        return {int(self.edges.target[e]): float(self.edges.cost[e]) for e in row}


def made_graph(chance: np.random.Generator, *, steps: int = 3, density: float = 0.4, lengths=(1, 1, 2, 4)) -> MadeGraph:
    """One to three clips of each step."""
    step, measure, length = [], [], []
    for s in range(steps):
        count = int(chance.choice(lengths))
        for _ in range(int(chance.integers(1, 4))):
            step += [s] * count
            measure += range(count)
            length += [count] * count
    rows = []
    for u in range(len(step)):
        if measure[u] < length[u] - 1:
            rows.append([u + 1])
        else:
            rows.append([v for v in range(len(step)) if measure[v] == 0 and chance.random() < density])
    return MadeGraph(made_edges(rows, chance), step, measure, length)


def made_edges(rows: list[list[int]], chance: np.random.Generator | None = None) -> Edges:
    """Edges to the nodes in each row, with random or zero costs."""
    target = np.array([v for row in rows for v in row], np.int32)
    cost = np.zeros(len(target)) if chance is None else chance.uniform(0.0, 0.3, len(target))
    return Edges(np.cumsum([0, *map(len, rows)]).astype(np.int32), target, cost)


def made_specification(graph: MadeGraph, names: Sequence[int | None]) -> SequenceSpec:
    """One entry for each step named; None is a measure of any step."""
    step, measure = np.array(graph.step), np.array(graph.measure)
    leaves = measure == np.array(graph.length) - 1
    wanted, fits, entry = [], [], []
    for number, name in enumerate(names):
        count = 1 if name is None else graph.length[graph.step.index(name)]
        wanted.append(SequenceEntry(name, count))
        for m in range(count):
            fits.append(np.ones(len(step), bool) if name is None else (step == name) & (measure == m))
            entry.append(number)
    if names[-1] is None:
        fits[-1] = fits[-1] & leaves  # the last step ends with the dance
    kind = np.arange(len(fits), dtype=np.int32)
    return SequenceSpec(tuple(wanted), np.array(fits), kind, np.array(entry, np.int32), measure == 0, leaves, False)


def enumerate_dances(graph: MadeGraph, measures: int, *, start: int | None = None):
    """All paths of so many measures with valid beginning and end, by recursion: (nodes, sum of edge costs)."""

    def further(path: tuple[int, ...], cost: float):
        if len(path) == measures:
            if graph.measure[path[-1]] == graph.length[path[-1]] - 1:
                yield path, cost
            return
        after = graph.follows(path[-1] if path else start)
        for v, price in after.items():
            yield from further((*path, v), cost + price)

    if start is not None:
        yield from further((), 0.0)
        return
    for node, measure in enumerate(graph.measure):
        if measure == 0:
            yield from further((node,), 0.0)
