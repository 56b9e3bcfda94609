"""LibraryWatch: a thread that sees takes come, change and go in a folder, and fits the graph of a running show."""

import threading
from collections.abc import Callable, Iterable
from dataclasses import fields
from pathlib import Path
from typing import Final

import numpy as np

from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS, keep_running
from live.control.events.events import ControlEvent, StepsAdded, StepsChanged
from live.graph.library_insert import insert_clips
from live.graph.motion_graph import MotionGraph
from live.library.clip_text import clips_to_text
from live.library.step_folder import load_folder
from live.motion.step_clip import StepClip
from live.show.polite import polite
from live.show.score.step_names import UnknownStep
from live.show.selection.library_hash import library_hash, steps_hash
from live.show.selection.new_steps import changed_graph, clip_key

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
