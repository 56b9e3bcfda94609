"""New steps: a motion graph that has grown while the show runs waits here for the next measure line.

Library hash: by which steps are known again: a replay and a snapshot need the same.

LibraryWatch: a thread that sees takes come, change and go in a folder, and fits the graph of a running show.
"""

import hashlib
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Final

import numpy as np

from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS, keep_running
from live.control.events import events
from live.control.events.events import ControlEvent, StepsAdded, StepsChanged
from live.graph.library_insert import insert_clips, stranded, without_clips
from live.graph.motion_graph import MotionGraph
from live.graph.select.selector import Choosing
from live.graph.step_library import StepLibrary
from live.library.clip_text import clips_from_text, clips_to_text
from live.library.step_folder import load_folder
from live.motion.step_clip import StepClip
from live.show.background_work import polite
from live.show.dancers.dancers import Dancers
from live.show.desk.refusals import Refusals
from live.show.score.step_names import UnknownStep

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


def library_hash(library: StepLibrary) -> str:
    """A short hash over every bit of the library's motion and of what decides its edges: a replay needs the same."""
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
    """The same of a graph's library, that some of its clips are not begun any more included."""
    found = library_hash(graph.library)
    if not graph.leaving.any():
        return found
    return hashlib.blake2b(found.encode() + graph.leaving.tobytes(), digest_size=8).hexdigest()


POLL_S: Final = 1.0
"""Seconds between two looks at the folder; it must look the same twice, so that nothing half written is read."""
LONGEST: Final = 4_000_000
"""Characters of changed clips that one event may hold: more wait for the next start."""
Stamp = tuple[tuple[str, int, int], ...]


class LibraryWatch:
    """Watches one folder. What is new there is read, measured against everything and joined in this thread; the show
    takes the new graph up at a measure line. What was changed or taken away is not begun any more from then on.
    """

    def __init__(
        self,
        folder: Path,
        graph: MotionGraph,
        *,
        offer: Callable[[str, MotionGraph], None],
        post: Callable[[ControlEvent], None],
        now: Callable[[], float],
        read: Callable[[], list[StepClip]] | None = None,
    ) -> None:
        """`offer` hands a graph over under its hash, `post` the event that calls for it, at the time `now()`.

        `read`: all clips as a start would find them; without it only the folder is read, and nothing counts as gone.
        """
        self._folder = folder
        self._read = read
        self.graph = graph
        """The graph that was offered last."""
        self._offer, self._post, self._now = offer, post, now
        self._known = {clip_key(clip): clip for clip in graph.library.clips}
        self._seen = self._taken = stamp_of(folder)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="library watch", daemon=True)
        self.prove: Callable[[MotionGraph], object] = lambda graph: None
        """Raises a PersonError or UnknownStep if the show could not go on in a graph."""
        self.problem = ""
        """Why the last change of the folder could not be taken; empty if it could."""
        self.joined = ""
        """What has joined last, in words; empty before."""

    def start(self) -> None:
        """Begin to watch."""
        self._thread.start()

    def stop(self) -> None:
        """End, and wait for what is being read."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join(timeout=10.0)

    def _run(self) -> None:
        keep_running("the watch of the steps", self._watch, self._ended.wait)

    def _watch(self) -> None:
        while not self._ended.wait(POLL_S):
            self.look()

    def again(self) -> None:
        """What could not be taken is looked at once more: the patch is another one."""
        if self.problem:
            self._taken = ()

    def look(self) -> bool:
        """Look once; True if something was joined, changed or taken away."""
        stamp = stamp_of(self._folder)
        settled, self._seen = stamp == self._seen, stamp
        if not settled or stamp == self._taken:
            return False
        self._taken = stamp
        try:
            with polite():
                clips = load_folder(self._folder) if self._read is None else self._read()
                self.problem = ""
                return self._take(clips)
        except (PersonError, UnknownStep, ValueError, OSError) as error:
            self.problem = f"new steps: {error}"
            return False
        except Exception as error:  # the program's own fault: the watch goes on, and whoever added them is told
            FAULTS.note("the reader of new steps", error)
            self.problem = f"new steps: they cannot be read ({type(error).__name__}: {error})"
            return False

    def _take(self, clips: list[StepClip]) -> bool:
        """Fit the graph to these clips; whether it changed."""
        fitting = [clip for clip in clips if clip.beats_per_measure == self.graph.library.beats_per_measure]
        if len(fitting) < len(clips):
            names = words_of(clip for clip in clips if clip not in fitting and clip_key(clip) not in self._known)
            beats = self.graph.library.beats_per_measure
            if names:
                self.problem = f"new steps: {names} can be danced only in another show: this one has {beats} beats"
        there = {clip_key(clip): clip for clip in fitting}
        gone = [] if self._read is None else [clip for name, clip in self._known.items() if name not in there]
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
        self._known.update({clip_key(clip): clip for clip in came})
        return True

    def _join(self, came: list[StepClip]) -> None:
        graph = insert_clips(self.graph, came)
        found = library_hash(graph.library)
        self.graph = graph
        self.joined = f"new steps: {words_of(came)} can be danced"
        self._offer(found, graph)
        keys = "\n".join(clip_key(clip) for clip in came)
        self._post(StepsAdded(time=self._now(), source="library", clips=keys, library=found))

    def _change(self, gone: list[StepClip], came: list[StepClip]) -> None:
        names = [clip_key(clip) for clip in gone]
        graph = changed_graph(self.graph, names, came)
        self.prove(graph)
        was, now = clips_to_text(gone), clips_to_text(came)
        if len(was) + len(now) > LONGEST:
            raise ValueError(f"{words_of(gone)}: so much has changed that it counts from the next start on")
        found = steps_hash(graph)
        self.graph = graph
        lost = [clip for clip in gone if clip.step not in {other.step for other in came}]
        told = [f"{words_of(came)} danced as they are now"] if came else []
        told += [f"{words_of(lost)} not begun any more"] if lost else []
        self.joined = f"new steps: {', '.join(told)}"
        self._offer(found, graph)
        event = StepsChanged(
            time=self._now(), source="library", gone="\n".join(names), was=was, now=now, library=found
        )  # fmt: skip
        self._post(event)


def words_of(clips: Iterable[StepClip]) -> str:
    """The steps of some clips."""
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


def stamp_of(folder: Path) -> Stamp:
    """Names, times and sizes of the files of a folder: it changes when they do."""
    rows = []
    try:
        for path in folder.iterdir():
            if path.is_file():
                facts = path.stat()
                rows.append((path.name, facts.st_mtime_ns, facts.st_size))
    except OSError:  # it is being moved, or a file has just gone: look again later
        return ()
    return tuple(sorted(rows))
