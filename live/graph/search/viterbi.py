"""Layered search: the cheapest path through measures × nodes, backwards from the end of the dance (T063, T065).

The thesis searches depth first (T064), which is exponential where dead ends are found late. The cost of the best
remaining dance depends only on the measure and the node, so one pass over the edges per measure finds it for all nodes:
O(M · E) time. Memory is bounded: of long dances every Bth layer is kept, and the layers between are recomputed.
"""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from live.base.arrays import Bool, Float64, Int32, Int64
from live.graph.distance_kernels import cheapest_successors

if TYPE_CHECKING:
    from live.graph.search.sequence_spec import SequenceSpec


MAX_KEPT_VALUES: Final = 1 << 22
"""Costs kept in a block of layers: 32 MB."""


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """Edges as compressed rows: those of node u are start[u] to start[u + 1]."""

    start: Int32
    """Shape (N + 1,)."""
    target: Int32
    """Shape (E,)."""
    cost: Float64
    """Cost of each edge, 0 or more, shape (E,)."""
    _rows: "list[_Rows]" = field(default_factory=list)

    @property
    def rows(self) -> "_Rows":
        """All edges grouped by source; computed once."""
        if not self._rows:
            self._rows.append(_Rows.of(self, np.ones(len(self.start) - 1, np.bool_)))
        return self._rows[0]


class CostToGo:
    """For every node in every measure, the cost of the best dance from there to the end.

    A cost counts wrong measures first and the sum of edge costs second: `unit` is more than the sum of all edges of a
    dance. Without `wrong`, only measures as specified are allowed, and every other node costs infinitely much.
    """

    def __init__(self, edges: Edges, specification: "SequenceSpec", *, wrong: bool, block: int | None = None) -> None:
        self.edges = edges
        self.specification = specification
        self.wrong = wrong
        measures, nodes = specification.measures, len(edges.start) - 1
        self.unit = 1.0 + (measures + 1) * float(edges.cost.max(initial=0.0))
        """Cost of a wrong measure."""
        self._block = max(2, block or MAX_KEPT_VALUES // max(nodes, 1))
        kinds = specification.fits
        self._rows = [edges.rows] if wrong else [_Rows.of(edges, fit) for fit in kinds]
        self._own_cost = np.where(kinds, 0.0, self.unit if wrong else np.inf)
        self._last = np.where(specification.leaves, 0.0, np.inf)
        self._checkpoints = self._compute_checkpoints()
        self._first, self._layers = -1, np.empty((0, nodes))

    def layer(self, measure: int) -> Float64:
        """Return the costs from a measure on, including it, shape (N,); fast when called in the order of the dance."""
        block = measure - measure % self._block
        if block != self._first:
            self._first, self._layers = block, self._compute_block(block)
        return np.asarray(self._layers[measure - block], np.float64)

    def wrong_measures(self, value: float) -> int:
        """Return the number of wrong measures in a cost."""
        return int(value // self.unit)

    def _compute_checkpoints(self) -> dict[int, Float64]:
        """Return the first layer of every block but the first, from the end to the beginning."""
        marks: dict[int, Float64] = {}
        value = self._last
        for measure in range(self.specification.measures - 1, self._block - 1, -1):
            value = self._before(measure, value)
            if measure % self._block == 0:
                marks[measure] = value
        return marks

    def _compute_block(self, block: int) -> Float64:
        last = min(block + self._block, self.specification.measures)
        layers = np.empty((last - block, len(self._last)))
        value = self._checkpoints.get(last, self._last)
        for measure in range(last - 1, block - 1, -1):
            value = layers[measure - block] = self._before(measure, value)
        return layers

    def _before(self, measure: int, value: Float64) -> Float64:
        """Return the layer of a measure from that of the next one; for the last measure from `_last`, without edges."""
        kind = self.specification.set_index[measure]
        if measure == self.specification.measures - 1:
            return np.asarray(value + self._own_cost[kind])
        rows = self._rows[0 if self.wrong else kind]
        out = np.empty(len(value))
        cheapest_successors(out, rows.node, rows.first, rows.target, rows.cost, value)
        return np.asarray(out + self._own_cost[kind])


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """The edges that leave some of the nodes, grouped by source; nodes without edges are left out."""

    node: Int64
    first: Int64
    target: Int32
    cost: Float64

    @classmethod
    def of(cls, edges: Edges, chosen: Bool) -> "_Rows":
        count = np.diff(edges.start)
        node = np.flatnonzero(chosen & (count > 0))
        length = count[node]
        first = np.cumsum(length) - length
        if chosen.all():
            return cls(node, first, edges.target, edges.cost)
        edge = np.arange(int(length.sum())) + np.repeat(edges.start[node] - first, length)
        return cls(node, first, edges.target[edge], edges.cost[edge])


def cheapest_path(costs: CostToGo, start: int | None) -> Int32 | None:
    """Return the cheapest dance as nodes (M,), from the beginning of a step or after `start`; None if there is none.

    Among equal costs, the dance whose nodes come first in the library is returned.
    """
    edges, spec = costs.edges, costs.specification
    nodes = np.empty(spec.measures, np.int32)
    before = start
    for measure in range(spec.measures):
        value, target = costs.layer(measure), None
        if before is None:
            value = np.where(spec.enters, value, np.inf)
        else:
            row = slice(edges.start[before], edges.start[before + 1])
            target = edges.target[row]
            value = edges.cost[row] + value[target]
        if not len(value) or not np.isfinite(value.min()):
            return None
        best = int(np.argmin(value))
        before = best if target is None else int(target[best])
        nodes[measure] = before
    return nodes
