"""Sequences that are changed while they are danced, with results well before the measure line.

A group keeps one `LiveSequence`. Its search covers all nodes, so all dancers of the group share one search over a few
measures (`HORIZON`). It runs after a measure line, beats before the next measures are chosen.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from live.base.arrays import Float64, Int32
from live.graph.search.sequence import edges_of
from live.graph.search.sequence_spec import SequenceEntry, SequenceSpec, specify
from live.graph.search.viterbi import CostToGo, Edges

if TYPE_CHECKING:
    from live.graph.motion_graph import MotionGraph


HORIZON: Final = 8
"""Measures that a live search looks ahead."""


def _with_horizon(graph: "MotionGraph", wanted: Sequence[SequenceEntry], horizon: int) -> SequenceSpec:
    """Return the specification of exactly `horizon` measures: longer ones are cut, shorter ones end with any steps."""
    entries: list[SequenceEntry] = []
    measures = 0
    for entry in wanted:
        if measures >= horizon:
            break
        entries.append(entry)
        measures += entry.measures
    # if cut in the middle of a step, the dance need not end a step
    full = specify(graph.library, [*entries, *[SequenceEntry(None)] * max(horizon - measures, 1)], repeats=True)
    return replace(
        full,
        set_index=full.set_index[:horizon],
        entry_index=full.entry_index[:horizon],
        leaves=np.ones_like(full.leaves),
    )


class LiveSequence:
    """The sequence that a group dances; it can be changed while it is danced.

    The show calls `costs_ahead` once per measure, after the line, and passes the result to `choose_measures` as the
    cost of each next node, so that path and heading decide among the nodes that keep the sequence. It calls `advance`
    when the measure is chosen. `feasible_delay` tests whether a change can be danced before it is made; a change that
    cannot be danced has no effect.
    """

    def __init__(
        self,
        graph: "MotionGraph",
        wanted: Sequence[SequenceEntry],
        *,
        horizon: int = HORIZON,
        edges: Edges | None = None,
    ) -> None:
        """`edges`: those of the graph, if several searches share them."""
        self._graph = graph
        self._edges = edges_of(graph) if edges is None else edges
        self._horizon = horizon
        self._wanted = list(wanted)
        self._measures_done = 0

    @property
    def remaining(self) -> tuple[SequenceEntry, ...]:
        """Return the remaining entries, including the current one."""
        return tuple(self._wanted)

    def extend(self, wanted: Sequence[SequenceEntry]) -> None:
        """Append entries to the sequence."""
        self._wanted += wanted

    def replace(self, wanted: Sequence[SequenceEntry]) -> None:
        """Replace the sequence from the next unchosen measure on; a step that has begun is danced to its end."""
        kept = self._wanted[:1] if self._measures_done else []
        self._wanted = [*kept, *wanted]

    def advance(self) -> None:
        """Advance by one measure, after the next one has been chosen."""
        if not self._wanted:
            return
        self._measures_done += 1
        if self._measures_done >= self._wanted[0].measures:
            self._wanted.pop(0)
            self._measures_done = 0

    def costs_ahead(self) -> Float64:
        """Return the number of wrong measures within the horizon if each node is danced next, (N,); inf: impossible.

        The fraction (below 1) is the roughness of the joins, so nodes are compared by both.
        """
        costs = self._costs(self._wanted, self._measures_done)
        return costs.layer(0) / costs.unit

    def feasible_delay(self, wanted: Sequence[SequenceEntry], nodes: Int32, *, max_delay: int = 2) -> int | None:
        """Return after how many free measures, at most `max_delay`, dancers in `nodes` (A,) can dance `wanted`.

        None if that is not possible for all of them: the current sequence should then be kept, and
        `live.graph.search.path_diagnostics` explains the reason. Dancers within a step first finish it.
        """
        library = self._graph.library
        at = nodes + library.node_measures[nodes] - 1 - library.node_measure[nodes]
        for wait in range(max_delay + 1):
            costs = self._costs([*[SequenceEntry(None)] * wait, *wanted], 0)
            value = costs.layer(0)
            best = [
                value[self._edges.target[self._edges.start[n] : self._edges.start[n + 1]]].min(initial=np.inf)
                for n in np.unique(at)
            ]
            if all(np.isfinite(v) and costs.wrong_measures(v) == 0 for v in best):
                return wait
        return None

    def _costs(self, wanted: Sequence[SequenceEntry], into: int) -> CostToGo:
        spec = _with_horizon(self._graph, wanted, self._horizon + into)
        spec = replace(spec, set_index=spec.set_index[into:], entry_index=spec.entry_index[into:])
        return CostToGo(self._edges, spec, wrong=True)
