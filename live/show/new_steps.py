"""New steps: a motion graph that has grown while the show runs waits here for the next measure line."""

from collections.abc import Mapping
from typing import Any

from live.control import events
from live.graph.choosing.choosing import Choosing
from live.graph.insertion import insert_clips, stranded
from live.graph.motion_graph import MotionGraph
from live.motion.step_clip import StepClip
from live.show.dancers import Dancers
from live.show.refusals import Refusals

GrownGraph = tuple[MotionGraph, Choosing]


class NewSteps:
    """Between the thread that joins new clips to the graph and the measure line at which they may be danced."""

    def __init__(self, reserve: Mapping[str, StepClip] | None, refusals: Refusals) -> None:
        """`reserve` holds the clips that a replay may add, by name: no thread joins them there."""
        self._reserve = dict(reserve or {})
        self._refusals = refusals
        self._offered: dict[str, GrownGraph] = {}
        self._next: GrownGraph | None = None

    @property
    def at_rest(self) -> bool:
        """Whether no graph waits for the measure line."""
        return self._next is None

    def stock(self, reserve: Mapping[str, StepClip]) -> None:
        """Hold these clips for events that add them, by name."""
        self._reserve = dict(reserve)

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_offered": {}, "_reserve": {}}  # of the process, not of the show's state

    def offer(self, library: str, graph: MotionGraph) -> None:
        """Hold a graph ready for the event StepsAdded that names its library's hash. Thread: any."""
        self._offered[library] = graph, Choosing.of(graph)

    def add(self, event: events.StepsAdded, graph: MotionGraph) -> None:
        """Have the offered graph danced from the next measure on; without one, join the clips to `graph` here."""
        offered = self._offered.pop(event.library, None)
        if offered is None:
            keys = event.clips.split("\n")
            if any(key not in self._reserve for key in keys):
                self._refusals.add(f"{event.source}: the new steps are not there any more")
                return
            known = graph if self._next is None else self._next[0]
            grown = insert_clips(known, [self._reserve[key] for key in keys])
            offered = grown, Choosing.of(grown)
        self._next = offered

    @property
    def coming(self) -> MotionGraph | None:
        """The graph that waits for the next measure line; None if there is none."""
        return None if self._next is None else self._next[0]

    def take(self, dancers: Dancers) -> GrownGraph | None:
        """The graph to dance in from this measure line on, unless it would leave somebody without a way on."""
        offered, self._next = self._next, None
        if offered is not None and stranded(offered[0], dancers.node).any():
            self._refusals.add("library: the new steps would leave dancers without a next step; they wait")
            return None
        return offered
