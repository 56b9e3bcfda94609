"""New steps: a motion graph that has grown while the show runs waits here for the next measure line."""

from collections.abc import Mapping, Sequence

import numpy as np

from live.control.events import events
from live.graph.library_insert import insert_clips, stranded, without_clips
from live.graph.motion_graph import MotionGraph
from live.graph.select.selector import Choosing
from live.library.clip_text import clips_from_text
from live.motion.step_clip import StepClip
from live.show.dancers.dancers import Dancers
from live.show.desk.refusals import Refusals

GrownGraph = tuple[MotionGraph, Choosing]


def clip_key(clip: StepClip) -> str:
    """What tells a clip from all others of a folder, on one line."""
    return f"{clip.step} | {clip.clip.name} | {'mirrored' if clip.mirrored else 'as made'}"


def changed_graph(graph: MotionGraph, gone: Sequence[str], came: Sequence[StepClip]) -> MotionGraph:
    """The graph with clips that came, in which nobody begins those of the names `gone` any more.

    ValueError if there is none of such a name, or nothing is left to be danced.
    """
    library = graph.library
    left = set(np.unique(library.node_clip[graph.leaving]).tolist())
    names: dict[str, int] = {clip_key(clip): n for n, clip in enumerate(library.clips) if n not in left}
    unknown = next((name for name in gone if name not in names), None)
    if unknown is not None:
        raise ValueError(f"there is no clip {unknown[:80]!r} that could be taken away")
    return without_clips(insert_clips(graph, came) if came else graph, [names[name] for name in gone])


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

    def offer(self, library: str, graph: MotionGraph) -> None:
        """Hold a graph ready for the event StepsAdded that names its library's hash. Thread: any."""
        self._offered[library] = graph, Choosing.of(graph)

    def hear(self, event: events.StepsAdded | events.StepsChanged, graph: MotionGraph) -> None:
        """Have what an event speaks of danced from the next measure on; `graph` is danced now."""
        if isinstance(event, events.StepsAdded):
            self._add(event, graph)
        else:
            self._change(event, graph)

    def _add(self, event: events.StepsAdded, graph: MotionGraph) -> None:
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

    def _change(self, event: events.StepsChanged, graph: MotionGraph) -> None:
        """Have the offered graph danced from the next measure on, in which clips are gone or others; without one, make
        it here, out of the event."""
        offered = self._offered.pop(event.library, None)
        if offered is None:
            try:
                known = graph if self._next is None else self._next[0]
                grown = changed_graph(known, event.gone.split("\n"), clips_from_text(event.now))
            except ValueError as error:
                self._refusals.add(f"{event.source}: {error}")
                return
            offered = grown, Choosing.of(grown)
        self._next = offered

    def drop(self) -> None:
        """The graph that waits is given up."""
        self._next = None

    @property
    def coming(self) -> MotionGraph | None:
        """The graph that waits for the next measure line; None if there is none."""
        return None if self._next is None else self._next[0]

    def take(self, dancers: Dancers) -> GrownGraph | None:
        """The graph to dance in from this measure line on, unless it would leave somebody without a way on."""
        offered = self._next
        if offered is not None and stranded(offered[0], dancers.node).any():
            self._refusals.add("library: the new steps would leave dancers without a next step; they wait")
            return None
        self._next = None
        return offered
