"""Updates of the motion graph while a show runs: a watcher of the step folder, and the swap at a measure line.

Hashes of the library identify its steps: a replay and a snapshot need the same ones.
"""

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Final

import numpy as np

from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS
from live.control.events import events
from live.control.events.events import ControlEvent, StepsAdded, StepsChanged
from live.graph.library_insert import insert_clips, stranded, without_clips
from live.graph.motion_graph import MotionGraph
from live.graph.select.selector import StepSelector
from live.graph.step_library import StepLibrary
from live.library.clip_text import clips_from_text, clips_to_text
from live.motion.step_clip import StepClip
from live.show.background_work import short_switch_interval
from live.show.dancers.dancers import Dancers
from live.show.desk.refusals import Refusals
from live.show.score.step_names import UnknownStep

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


class GraphUpdates:
    """Holds new motion graphs from the watcher's thread until the measure line at which they are used."""

    def __init__(self, reserve: Mapping[str, StepClip] | None, refusals: Refusals) -> None:
        """`reserve` holds the clips that a replay may add, by key: a replay has no watcher."""
        self._reserve = dict(reserve or {})
        self._refusals = refusals
        self._offered: dict[str, GrownGraph] = {}
        self._next: GrownGraph | None = None

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
                grown = updated_graph(known, event.gone.split("\n"), clips_from_text(event.now))
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

    def pop(self, dancers: Dancers) -> GrownGraph | None:
        """Return and clear the waiting graph; None if there is none, or if it would leave a dancer without a next step,
        in which case it keeps waiting."""
        offered = self._next
        if offered is not None and stranded(offered[0], dancers.node).any():
            self._refusals.add("library: the new steps would leave dancers without a next step; they wait")
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


MAX_EVENT_CHARACTERS: Final = 4_000_000
"""Most characters of changed clips in one event: larger changes wait for the next start."""
Stamp = tuple[tuple[str, int, int], ...]


class LibraryWatch:
    """Watches one folder of steps. `poll` reads new clips and inserts them into the graph; the show switches to the new
    graph at a measure line. The old versions of changed or removed clips are not begun any more from then on.
    """

    def __init__(
        self,
        folder: Path,
        graph: MotionGraph,
        *,
        offer: Callable[[str, MotionGraph], None],
        post: Callable[[ControlEvent], None],
        now: Callable[[], float],
        read: Callable[[], list[StepClip]],
    ) -> None:
        """`offer` passes on a graph with its hash, `post` the event that activates it, at the time `now()`.

        `read` returns all clips as at a start.
        """
        self._folder = folder
        self._read = read
        self.graph = graph
        """The graph offered last."""
        self._offer, self._post, self._now = offer, post, now
        self._known = clips_by_key(graph.library.clips)
        self._last_stamp = self._handled_stamp = folder_stamp(folder)
        self.check: Callable[[MotionGraph], object] = lambda graph: None
        """Check that raises a PersonError or UnknownStep if the show cannot use a graph."""
        self.problem = ""
        """Why the last change of the folder was refused, empty if it was not."""
        self.last_change = ""
        """Description of the last change, empty before the first."""

    def retry(self) -> None:
        """Try a refused change again, after a change of the patch."""
        if self.problem:
            self._handled_stamp = ()

    def poll(self) -> bool:
        """Poll once. Returns whether clips were added, changed or removed."""
        stamp = folder_stamp(self._folder)
        settled, self._last_stamp = stamp == self._last_stamp, stamp
        if not settled or stamp == self._handled_stamp:
            return False
        self._handled_stamp = stamp
        try:
            with short_switch_interval():
                clips = self._read()
                self.problem = ""
                return self._update(clips)
        except (PersonError, UnknownStep, ValueError, OSError) as error:
            self.problem = f"new steps: {error}"
            return False
        except Exception as error:  # a bug: keep watching, and report it
            FAULTS.record("the reader of new steps", error)
            self.problem = f"new steps: they cannot be read ({type(error).__name__}: {error})"
            return False

    def _update(self, clips: list[StepClip]) -> bool:
        """Update the graph to these clips. Returns whether it changed."""
        fitting = [clip for clip in clips if clip.beats_per_measure == self.graph.library.beats_per_measure]
        if len(fitting) < len(clips):
            names = step_list(clip for clip in clips if clip not in fitting and clip_key(clip) not in self._known)
            beats = self.graph.library.beats_per_measure
            if names:
                self.problem = f"new steps: {names} do not fit this show, whose measures have {beats} beats"
        there = clips_by_key(fitting)
        gone = [clip for name, clip in self._known.items() if name not in there]
        old = {name: self._known[name] for name in there if name in self._known}
        gone += [clip for name, clip in old.items() if not same_clip(clip, there[name])]
        left = {clip_key(clip) for clip in gone}
        came = [clip for name, clip in there.items() if name not in self._known or name in left]
        if gone:
            self._change(gone, came)
        elif came:
            self._join(came)
        else:
            return False
        for name in left:
            del self._known[name]
        self._known.update(clips_by_key(came))
        return True

    def _join(self, came: list[StepClip]) -> None:
        graph = insert_clips(self.graph, came)
        found = library_hash(graph.library)
        self.graph = graph
        self.last_change = f"new steps: {step_list(came)} can be danced"
        self._offer(found, graph)
        keys = "\n".join(clip_key(clip) for clip in came)
        self._post(StepsAdded(time=self._now(), source="library", clips=keys, library=found))

    def _change(self, gone: list[StepClip], came: list[StepClip]) -> None:
        names = [clip_key(clip) for clip in gone]
        graph = updated_graph(self.graph, names, came)
        self.check(graph)
        was, now = clips_to_text(gone), clips_to_text(came)
        if len(was) + len(now) > MAX_EVENT_CHARACTERS:
            raise ValueError(f"{step_list(gone)}: the change is too large for a running show; restart to use it")
        found = steps_hash(graph)
        self.graph = graph
        lost = [clip for clip in gone if clip.step not in {other.step for other in came}]
        told = [f"{step_list(came)} danced as they are now"] if came else []
        told += [f"{step_list(lost)} not begun any more"] if lost else []
        self.last_change = f"new steps: {', '.join(told)}"
        self._offer(found, graph)
        event = StepsChanged(
            time=self._now(), source="library", gone="\n".join(names), was=was, now=now, library=found
        )  # fmt: skip
        self._post(event)


def step_list(clips: Iterable[StepClip]) -> str:
    """Return the steps of clips as a sorted list in words, at most 200 characters."""
    return ", ".join(sorted({clip.step for clip in clips}))[:200]


def same_clip(one: StepClip, other: StepClip) -> bool:
    """Whether two clips are the same, bit by bit."""
    if one is other:
        return True
    arrays = ("root_position", "rotation", "contact")
    facts = [field.name for field in fields(StepClip) if field.name != "clip"]
    return (
        all(getattr(one, name) == getattr(other, name) for name in facts)
        and (one.clip.name, one.clip.sample_rate) == (other.clip.name, other.clip.sample_rate)
        and all(np.array_equal(getattr(one.clip, name), getattr(other.clip, name)) for name in arrays)
    )


def folder_stamp(folder: Path, suffix: str = "") -> Stamp:
    """Return names, times and sizes of the files of a folder that end with `suffix`, to detect changes."""
    rows = []
    try:
        for path in folder.iterdir():
            if path.name.endswith(suffix) and path.is_file():
                facts = path.stat()
                rows.append((path.name, facts.st_mtime_ns, facts.st_size))
    except OSError:  # the folder is being moved, or a file was just deleted: poll again later
        return ()
    return tuple(sorted(rows))
