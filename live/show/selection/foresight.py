"""Foresight: of every next node how many measures of what is wanted would go wrong, kept for what comes again."""

from collections import OrderedDict
from typing import Final

import numpy as np
import numpy.typing as npt

from live.graph.motion_graph import MotionGraph
from live.graph.search.live_sequence import LiveSequence
from live.graph.search.sequence import edges_of
from live.graph.search.sequence_spec import Wanted

Float64 = npt.NDArray[np.float64]

KEPT: Final = 64
"""Answers kept: a sequence that is danced again and again asks the same questions."""
NOW: Final = 0.25
"""A wrong measure at once counts this much more than a later one."""
IMPOSSIBLE: Final = 1000.0


class Foresight:
    """Answers for all dancers of all groups over one graph; a group's dancers share an answer."""

    def __init__(self, graph: MotionGraph) -> None:
        self._graph, self._edges = graph, edges_of(graph)
        self._kept: OrderedDict[tuple[tuple[Wanted, ...], int], Float64] = OrderedDict()
        self._steps: dict[int, Float64] = {}

    def sequence(self, wanted: tuple[Wanted, ...], into: int) -> Float64:
        """Wrong measures within the horizon if a node is danced next, (N,): `wanted` is what comes, `into` of whose
        first entry's measures are over (the layered search of T063-T065 over eight measures)."""
        key = (wanted, into)
        if key in self._kept:
            self._kept.move_to_end(key)
            return self._kept[key]
        live = LiveSequence(self._graph, wanted, edges=self._edges)
        for _ in range(into):
            live.advance()
        answer = np.minimum(live.ahead(), IMPOSSIBLE)
        first, library = wanted[0], self._graph.library
        if first.step is not None:
            right = (library.node_step == first.step) & (library.node_measure == into)
            answer = answer + NOW * ~right
        self._kept[key] = answer
        if len(self._kept) > KEPT:
            self._kept.popitem(last=False)
        return answer

    def step(self, step: int) -> Float64:
        """The same where only one step counts, as soon as it can be reached: measures away from it, (N,)."""
        if step not in self._steps:
            away = self._graph.library.node_step != step
            self._steps[step] = np.where(away, 1.0 + np.minimum(self._graph.hops[step], IMPOSSIBLE), 0.0)
        return self._steps[step]
