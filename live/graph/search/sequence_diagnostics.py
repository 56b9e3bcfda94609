"""Gaps: where a wanted sequence cannot be danced, and the fewest joins that would let it be (T065).

Wrong steps: which nodes are not the wanted step in which measure, and how many such measures are still to come.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.graph.motion_graph import MotionGraph
from live.graph.search.sequence_spec import Specification
from live.graph.search.viterbi import CostToGo, Edges

Bool = npt.NDArray[np.bool_]
Float64 = npt.NDArray[np.float64]

ChoosePair = Callable[[Bool, Bool], tuple[int, int]]
"""Which of some last nodes, and which of some first nodes, is best joined; both (N,)."""


@dataclass(frozen=True, slots=True)
class Gap:
    """A place in the dance that nothing bridges."""

    measure: int
    """The measure, from 0, that cannot be reached, or has no clip at all."""
    pair: tuple[int, int] | None = None
    """The join that is missing, from node to node; None if no join would do."""
    has_clip: bool = True
    """Whether any clip does what is wanted in that measure."""


def find_gaps(edges: Edges, specification: Specification, choose: ChoosePair, *, start: int | None = None) -> list[Gap]:
    """The gaps of a dance that begins with any step, or after the node `start`; none if it can be danced.

    There are as few joins as can be, each as late as can be, and they belong to one dance: with them it can be danced
    from beginning to end. Linear in its measures and the edges.
    """
    gaps: list[Gap] = []
    begin = 0
    lacking = np.flatnonzero(~specification.fits.any(axis=1))
    empty = np.flatnonzero(np.isin(specification.kind, lacking))
    for entry in np.unique(specification.entry[empty]):  # what has no clip parts the dance
        own = np.flatnonzero(specification.entry == entry)
        gaps += _Stretch(edges, specification, begin, int(own[0]), choose).find(start)
        gaps.append(Gap(int(own[0]), has_clip=False))
        begin, start = int(own[-1]) + 1, None
    return gaps + _Stretch(edges, specification, begin, specification.measures, choose).find(start)


class _Stretch:
    """Measures `begin` to `stop` of a dance, each of which some clips would do."""

    def __init__(self, edges: Edges, specification: Specification, begin: int, stop: int, choose: ChoosePair) -> None:
        self._spec = replace(specification, kind=specification.kind[begin:stop])
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
            here, left = self._go_on(here, left, 0)
        for measure in range(1, spec.measures):
            here, left = self._go_on(here, left, measure)
        if left > 0.0:  # it ends within a step
            self._gaps.append(Gap(self._begin + spec.measures - 1))
        return self._gaps

    def _enter(self) -> tuple[Bool, float]:
        """The nodes with which the stretch begins best, and what they cost to its end."""
        value = self._costs.layer(0)
        least = float((value + np.where(self._spec.enters, 0.0, self._costs.broken)).min())
        here = (value == least) & self._spec.enters
        if here.any():
            return here, least
        self._gaps.append(Gap(self._begin))
        return np.asarray(value == least - self._costs.broken), least - self._costs.broken

    def _go_on(self, here: Bool, left: float, measure: int) -> tuple[Bool, float]:
        """From the nodes `here`, which cost `left` to the end, to the best of the next measure."""
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
        left -= self._costs.broken
        there = np.asarray(value == left)
        self._gaps.append(Gap(self._begin + measure))
        return there & self._spec.enters if (there & self._spec.enters).any() else there, left


class _JoinsToGo(CostToGo):
    """Of every node the joins that a dance as specified lacks from there to its end.

    An edge costs nothing, the join of another end and beginning 1, and more than all of them to break off a step.
    """

    def __init__(self, edges: Edges, specification: Specification) -> None:
        self.broken = specification.measures + 1.0
        """What it costs to break off."""
        self.source = np.repeat(np.arange(len(edges.start) - 1), np.diff(edges.start))
        """Where each edge comes from, (E,)."""
        super().__init__(Edges(edges.start, edges.target, np.zeros(len(edges.target))), specification, wrong=False)

    def before(self, value: Float64, here: Bool, by_edges: Float64 | None = None) -> Float64:
        """What the nodes `here` (N,) cost to the end if those of the next measure cost `value` (N,)."""
        if by_edges is None:
            by_edges = np.full(len(value), np.inf)
            np.minimum.at(by_edges, self.source, value[self.edges.target])
        broken = self.broken + value.min()
        joined = 1.0 + value[self.specification.enters].min(initial=np.inf)
        others = np.where(self.specification.leaves, min(joined, broken), broken)
        return np.where(here, np.minimum(by_edges, others), np.inf)

    def _before(self, measure: int, value: Float64) -> Float64:
        fits = self.specification.at(measure)
        if measure == self.specification.measures - 1:
            return np.where(fits, np.where(self.specification.leaves, 0.0, self.broken), np.inf)
        return self.before(value, fits, super()._before(measure, value))


ANY: Final = -1
"""A measure in which any step is right."""


def wrong_steps(graph: MotionGraph, count: int, wanted: npt.ArrayLike | None, fits: Bool | None) -> Bool:
    """Whether each node would be another step than the wanted one in each of `count` measures, shape (M, N).

    `wanted` (M,) steps by index or `ANY`, `fits` (M, N) which nodes may be danced; ValueError for other shapes.
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
    """The fewest wrong measures, (M, N), after node v is danced in measure n, backwards over all edges; exact."""
    filled = np.flatnonzero(np.diff(graph.edge_start) > 0)
    starts = graph.edge_start[filled]
    left = np.full(wrong.shape, np.inf)
    left[-1] = 0.0
    for n in range(len(wrong) - 2, -1, -1):
        after = left[n + 1] + wrong[n + 1]
        left[n, filled] = np.minimum.reduceat(after[graph.edge_target], starts)
    return left
