"""Look-ahead of step selection: costs of nodes for coming steps, and predicted agents at the end of a measure."""

from collections import OrderedDict
from typing import TYPE_CHECKING, Final

import numpy as np

from live.agents.crowd.agent_state import AgentState
from live.agents.entrances.entrances import ON, Entrances
from live.agents.prediction import CrowdPrediction
from live.base.arrays import Bool, Float64
from live.graph.motion_graph import MotionGraph
from live.graph.search.live_sequence import LiveSequence
from live.graph.search.sequence import edges_of
from live.graph.search.sequence_spec import SequenceEntry, repeated_nodes
from live.show.group.elements import Elements
from live.show.group.stage_area import StageArea
from live.show.stages.measure_span import MeasureSpan

if TYPE_CHECKING:
    from live.show.group.evolutions import Evolutions


CACHE_SIZE: Final = 64
"""Size of the cache: repeated sequences need the same results."""
IMMEDIATE_COST: Final = 0.25
"""Additional cost of a wrong measure at once, relative to a later one."""
IMPOSSIBLE: Final = 1000.0


class StepCosts:
    """Costs of next nodes over one graph, with a cache. The dancers of a group share a result."""

    def __init__(self, graph: MotionGraph) -> None:
        self._graph, self._edges = graph, edges_of(graph)
        self._kept: OrderedDict[tuple[tuple[SequenceEntry, ...], int], Float64] = OrderedDict()
        self._steps: dict[int, Float64] = {}

    def sequence_cost(self, wanted: tuple[SequenceEntry, ...], into: int) -> Float64:
        """Return the number of wrong measures within the horizon for each next node, (N,).

        `wanted` is the coming sequence; `into` measures of its first entry are over. Computed by dynamic programming on
        layers over eight measures (T063-T065).
        """
        key = (wanted, into)
        if key in self._kept:
            self._kept.move_to_end(key)
            return self._kept[key]
        live = LiveSequence(self._graph, wanted, edges=self._edges)
        for _ in range(into):
            live.advance()
        answer = np.minimum(live.costs_ahead(), IMPOSSIBLE)
        first, library = wanted[0], self._graph.library
        if first.step is not None:
            right = (library.node_step == first.step) & (library.node_measure == into)
            right |= (library.node_step == first.step) & repeated_nodes(library, first.measures, into)
            answer = answer + IMMEDIATE_COST * ~right
        self._kept[key] = answer
        if len(self._kept) > CACHE_SIZE:
            self._kept.popitem(last=False)
        return answer

    def step_distance(self, step: int) -> Float64:
        """Return the number of measures from each next node to the single step `step`, (N,)."""
        if step not in self._steps:
            away = self._graph.library.node_step != step
            self._steps[step] = np.where(away, 1.0 + np.minimum(self._graph.hops[step], IMPOSSIBLE), 0.0)
        return self._steps[step]


RELEASE_INFLUENCE: Final = 0.5
"""From this influence on, an element ends a dancer's evolution."""


class AgentLookAhead:
    """Predicts the agents at the end of the next measure, a few steps at a time.

    Call `begin`, then `work` until all is done, then `ends`.
    """

    def __init__(
        self, look_ahead: CrowdPrediction, evolutions: "Evolutions", elements: Elements, entrances: Entrances,
        stage_area: StageArea, count: int, beats: int,
    ) -> None:  # fmt: skip
        """`look_ahead` simulates a copy of the `count` agents; `beats` of a danced measure."""
        self._look_ahead, self._evolutions, self._elements = look_ahead, evolutions, elements
        self._entrances, self._stage_area = entrances, stage_area
        self._count, self._beats = count, beats
        self._late: Float64 = np.zeros(count)

    def begin(self, state: AgentState, time: float, seconds: float, late: Float64, tempo: float) -> None:
        """Begin a prediction `seconds` [s] ahead of `time` [s] at `tempo` [bpm], with the intended delays `late` (A,)
        [beats]."""
        self._late = late
        self._look_ahead.begin(state, time=time, seconds=[seconds + beats * 60.0 / tempo for beats in np.unique(late)])

    def work(self, steps: int) -> None:
        """Run at most `steps` coarse steps."""
        self._look_ahead.run(steps)

    def ends(self, span: MeasureSpan | None) -> tuple[Float64, Bool, Float64]:
        """Return the predicted positions at the end of the measure after `span`, (A, 2) [m], which dancers are in an
        evolution then, (A,), and their headings, (A,) [rad]. Measures of delayed dancers end later."""
        place, heading = np.zeros((self._count, 2)), np.zeros(self._count)
        held = np.zeros(self._count, np.bool_)
        for beats, position in zip(np.unique(self._late), self._look_ahead.positions, strict=True):
            rows = self._late == beats
            place[rows] = position[rows]
            if span is None:
                continue
            known, planned, facing = self._evolutions.target((span.number + 2) * self._beats + beats)
            rows &= known & (self._elements.influence < RELEASE_INFLUENCE) & ~self._entrances.passing
            place[rows], heading[rows], held[rows] = planned[rows], facing[rows], True
        if self._stage_area.fit_size is not None:  # plans may have been made for a larger stage
            on = self._entrances.state == ON
            place[on] = np.clip(place[on], -self._stage_area.half, self._stage_area.half)
        return place, held, heading
