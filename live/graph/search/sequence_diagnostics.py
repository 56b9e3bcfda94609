"""Gaps in a sequence that cannot be danced, the fewest joins that would fix it (T065), and wrong-step counts."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float64
from live.graph.motion_graph import MotionGraph
from live.graph.search.sequence_spec import SequenceSpec
from live.graph.search.viterbi import CostToGo, Edges

ChoosePair = Callable[[Bool, Bool], tuple[int, int]]
"""Chooses which of some last nodes and which of some first nodes are best joined; both (N,)."""


@dataclass(frozen=True, slots=True)
class Gap:
    """A measure of the dance that no path reaches."""

    measure: int
    """The measure, from 0, that cannot be reached, or has no clip."""
    pair: tuple[int, int] | None = None
    """The missing join, from node to node; None if no join would help."""
    has_clip: bool = True
    """Whether any clip fits that measure."""


def find_gaps(edges: Edges, specification: SequenceSpec, choose: ChoosePair, *, start: int | None = None) -> list[Gap]:
    """Return the gaps of a dance that begins with any step, or after the node `start`; none if it is possible.

    There are as few joins as possible, each as late as possible, and with all of them the dance is possible from
    beginning to end. Linear in its measures and the edges.
    """
    gaps: list[Gap] = []
    begin = 0
    lacking = np.flatnonzero(~specification.fits.any(axis=1))
    empty = np.flatnonzero(np.isin(specification.set_index, lacking))
    for entry in np.unique(specification.entry_index[empty]):  # entries without a clip divide the dance
        own = np.flatnonzero(specification.entry_index == entry)
        gaps += _Stretch(edges, specification, begin, int(own[0]), choose).find(start)
        gaps.append(Gap(int(own[0]), has_clip=False))
        begin, start = int(own[-1]) + 1, None
    return gaps + _Stretch(edges, specification, begin, specification.measures, choose).find(start)


class _Stretch:
    """Measures `begin` to `stop` of a dance; each has clips that fit."""

    def __init__(self, edges: Edges, specification: SequenceSpec, begin: int, stop: int, choose: ChoosePair) -> None:
        self._spec = replace(specification, set_index=specification.set_index[begin:stop])
        self._edges = edges
        self._begin = begin
        self._choose = choose
        self._gaps: list[Gap] = []

    def find(self, start: int | None) -> list[Gap]:
        """Its gaps."""
        spec = self._spec
        if not spec.measures:
            return []
        self._costs = _JoinsToGo(self._edges, spec)
        if start is None:
            here, left = self._enter()
        else:
            here = np.zeros(len(spec.enters), np.bool_)
            here[start] = True
            left = float(self._costs.before(self._costs.layer(0), np.ones_like(here))[start])
            here, left = self._advance(here, left, 0)
        for measure in range(1, spec.measures):
            here, left = self._advance(here, left, measure)
        if left > 0.0:  # it ends within a step
            self._gaps.append(Gap(self._begin + spec.measures - 1))
        return self._gaps

    def _enter(self) -> tuple[Bool, float]:
        """Return the best nodes to begin the stretch with, and their cost to its end."""
        value = self._costs.layer(0)
        least = float((value + np.where(self._spec.enters, 0.0, self._costs.break_cost)).min())
        here = (value == least) & self._spec.enters
        if here.any():
            return here, least
        self._gaps.append(Gap(self._begin))
        return np.asarray(value == least - self._costs.break_cost), least - self._costs.break_cost

    def _advance(self, here: Bool, left: float, measure: int) -> tuple[Bool, float]:
        """Continue from the nodes `here`, which cost `left` to the end, to the best of the next measure."""
        value = self._costs.layer(measure)
        there = np.zeros_like(here)
        there[self._edges.target[here[self._costs.source]]] = True
        there &= value == left
        if there.any():
            return there, left
        first = self._spec.enters & (value == left - 1.0)
        if first.any() and (here & self._spec.leaves).any():
            u, v = self._choose(here & self._spec.leaves, first)
            self._gaps.append(Gap(self._begin + measure, (u, v)))
            there[v] = True
            return there, left - 1.0
        left -= self._costs.break_cost
        there = np.asarray(value == left)
        self._gaps.append(Gap(self._begin + measure))
        return there & self._spec.enters if (there & self._spec.enters).any() else there, left


class _JoinsToGo(CostToGo):
    """For every node, the joins that the specified dance lacks from there to its end.

    An edge costs 0, a join of another end and beginning 1, and breaking off a step more than all of them.
    """

    def __init__(self, edges: Edges, specification: SequenceSpec) -> None:
        self.break_cost = specification.measures + 1.0
        """Cost of breaking off a step."""
        self.source = np.repeat(np.arange(len(edges.start) - 1), np.diff(edges.start))
        """Source node of each edge, (E,)."""
        super().__init__(Edges(edges.start, edges.target, np.zeros(len(edges.target))), specification, wrong=False)

    def before(self, value: Float64, here: Bool, by_edges: Float64 | None = None) -> Float64:
        """Return the cost of the nodes `here` (N,) to the end if those of the next measure cost `value` (N,)."""
        if by_edges is None:
            by_edges = np.full(len(value), np.inf)
            np.minimum.at(by_edges, self.source, value[self.edges.target])
        broken = self.break_cost + value.min()
        joined = 1.0 + value[self.specification.enters].min(initial=np.inf)
        others = np.where(self.specification.leaves, min(joined, broken), broken)
        return np.where(here, np.minimum(by_edges, others), np.inf)

    def _before(self, measure: int, value: Float64) -> Float64:
        fits = self.specification.at(measure)
        if measure == self.specification.measures - 1:
            return np.where(fits, np.where(self.specification.leaves, 0.0, self.break_cost), np.inf)
        return self.before(value, fits, super()._before(measure, value))


ANY: Final = -1
"""A measure in which any step is allowed."""


def wrong_steps(graph: MotionGraph, count: int, wanted: npt.ArrayLike | None, fits: Bool | None) -> Bool:
    """Return whether each node would be a wrong step in each of `count` measures, shape (M, N).

    `wanted` (M,) are steps by index or `ANY`, `fits` (M, N) are allowed nodes; ValueError for other shapes.
    """
    library = graph.library
    shape = (count, library.node_count)
    wrong = np.zeros(shape, np.bool_)
    if wanted is not None:
        values = np.asarray(wanted, np.int64)
        if values.shape != (count,):
            raise ValueError(f"wanted steps of shape {values.shape}, ({count},) expected")
        wrong |= (values[:, None] != ANY) & (library.node_step[None] != values[:, None])
    if fits is not None:
        if fits.shape != shape:
            raise ValueError(f"fits of shape {fits.shape}, {shape} expected")
        wrong |= ~fits
    return wrong


def cost_to_go(graph: MotionGraph, wrong: Bool) -> Float64:
    """Return the exact minimum of wrong measures, (M, N), after node v in measure n, backwards over all edges."""
    filled = np.flatnonzero(np.diff(graph.edge_start) > 0)
    starts = graph.edge_start[filled]
    left = np.full(wrong.shape, np.inf)
    left[-1] = 0.0
    for n in range(len(wrong) - 2, -1, -1):
        after = left[n + 1] + wrong[n + 1]
        left[n, filled] = np.minimum.reduceat(after[graph.edge_target], starts)
    return left
