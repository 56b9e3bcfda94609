"""Updates of the motion graph while a show runs: new and changed clips, and the swap at a measure line.

Hashes of the library identify its steps: a replay and a snapshot need the same ones.
"""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from live.control.events import events
from live.graph.library_insert import insert_clips, stranded, without_clips
from live.graph.motion_graph import MotionGraph
from live.graph.select.selector import StepSelector
from live.graph.step_library import StepLibrary
from live.library.clip_text import clips_from_text
from live.motion.step_clip import StepClip
from live.show.desk.refusals import Refusals

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers

GrownGraph = tuple[MotionGraph, StepSelector]


def clip_key(clip: StepClip) -> str:
    """Return the key of a clip, unique within a folder, on one line."""
    return f"{clip.step} | {clip.clip.name} | {'mirrored' if clip.mirrored else 'as made'}"


def clips_by_key(clips: Iterable[StepClip]) -> dict[str, StepClip]:
    """Return clips by their keys, in order; the last clip of a key counts."""
    return {clip_key(clip): clip for clip in clips}


def updated_graph(graph: MotionGraph, removed: Sequence[str], added: Sequence[StepClip]) -> MotionGraph:
    """Return the graph with the clips `added`, in which the clips with the keys `removed` are not begun any more.

    Raises ValueError for an unknown key, or if no clip is left.
    """
    library = graph.library
    left = set(np.unique(library.node_clip[graph.leaving]).tolist())
    names: dict[str, int] = {clip_key(clip): n for n, clip in enumerate(library.clips) if n not in left}
    unknown = next((name for name in removed if name not in names), None)
    if unknown is not None:
        raise ValueError(f"there is no clip {unknown[:80]!r} that could be taken away")
    return without_clips(insert_clips(graph, added) if added else graph, [names[name] for name in removed])


def gone_clips(event: events.StepsChanged) -> list[str]:
    """Return the keys of the clips that an event takes away."""
    return event.gone.split("\n") if event.gone else []


class GraphUpdates:
    """Holds new motion graphs from the watcher's thread until the measure line at which they are used."""

    def __init__(self, reserve: Mapping[str, StepClip] | None, refusals: Refusals) -> None:
        """`reserve` holds the clips that a replay may add, by key: a replay has no watcher."""
        self._reserve = dict(reserve or {})
        self._refusals = refusals
        self._offered: dict[str, GrownGraph] = {}
        self._next: GrownGraph | None = None
        self._at_once = False

    @property
    def at_once(self) -> bool:
        """Whether a graph waits that is to be used before the measure line, if that is still possible."""
        return self._at_once and self._next is not None

    @property
    def at_rest(self) -> bool:
        """Whether no graph waits for the measure line."""
        return self._next is None

    def set_reserve(self, reserve: Mapping[str, StepClip]) -> None:
        """Set the clips for events that add them, by key."""
        self._reserve = dict(reserve)

    def offer(self, library: str, graph: MotionGraph) -> None:
        """Store a graph for the event that names its library's hash. Thread: any."""
        self._offered[library] = graph, StepSelector.of(graph)

    def handle(self, event: events.StepsAdded | events.StepsChanged, graph: MotionGraph) -> None:
        """Handle an event: its steps are used from the next measure on; `graph` is the present one."""
        if isinstance(event, events.StepsAdded):
            self._add(event, graph)
        else:
            self._change(event, graph)
            self._at_once = event.at_once

    def _add(self, event: events.StepsAdded, graph: MotionGraph) -> None:
        """Queue the offered graph for the next measure; without one, insert the clips into `graph` here."""
        offered = self._offered.pop(event.library, None)
        if offered is None:
            keys = event.clips.split("\n")
            if any(key not in self._reserve for key in keys):
                self._refusals.add(f"{event.source}: the new steps do not exist any more")
                return
            known = graph if self._next is None else self._next[0]
            grown = insert_clips(known, [self._reserve[key] for key in keys])
            offered = grown, StepSelector.of(grown)
        self._next = offered

    def _change(self, event: events.StepsChanged, graph: MotionGraph) -> None:
        """Queue the offered graph, with clips removed or changed, for the next measure; without one, build it here from
        the event."""
        offered = self._offered.pop(event.library, None)
        if offered is None:
            try:
                known = graph if self._next is None else self._next[0]
                grown = updated_graph(known, gone_clips(event), clips_from_text(event.now))
            except ValueError as error:
                self._refusals.add(f"{event.source}: {error}")
                return
            offered = grown, StepSelector.of(grown)
        self._next = offered

    def drop(self) -> None:
        """Drop the waiting graph."""
        self._next = None

    @property
    def waiting_graph(self) -> MotionGraph | None:
        """The graph that waits for the next measure line, None if there is none."""
        return None if self._next is None else self._next[0]

    def pop(self, dancers: "Dancers") -> GrownGraph | None:
        """Return and clear the waiting graph; None if there is none, or if it would leave a dancer without a next step,
        in which case it keeps waiting."""
        offered = self._next
        if offered is not None and stranded(offered[0], dancers.node).any():
            if not self._at_once:
                self._refusals.add("library: the new steps would leave dancers without a next step; they wait")
            self._at_once = False  # from now on it waits for the measure lines
            return None
        self._next = None
        return offered


def library_hash(library: StepLibrary) -> str:
    """Return a short hash of the library's motion data and of all facts that determine its edges."""
    digest = hashlib.blake2b(digest_size=8)
    for array in (
        library.clip_root, library.clip_rotation, library.clip_contact, library.node_first, library.node_last
    ):  # fmt: skip
        digest.update(np.ascontiguousarray(array).tobytes())
    for clip in library.clips:
        facts = (clip.step, clip.mirrored, clip.leading_foot, clip.begin_pose, clip.end_pose, clip.weight_transfer)
        digest.update(repr(facts).encode())
    return digest.hexdigest()


def steps_hash(graph: MotionGraph) -> str:
    """Return the hash of a graph's library, including which clips are not begun any more."""
    found = library_hash(graph.library)
    if not graph.leaving.any():
        return found
    return hashlib.blake2b(found.encode() + graph.leaving.tobytes(), digest_size=8).hexdigest()
