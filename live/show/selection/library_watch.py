"""Watch of the step folder while a show runs: new, changed and removed clips become a new motion graph."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Final

import numpy as np

from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS
from live.control.events.events import ControlEvent, StepsAdded, StepsChanged
from live.graph.library_insert import insert_clips
from live.graph.motion_graph import MotionGraph
from live.library.clip_text import clips_to_text
from live.motion.editing.tempo_forms import TempoForms
from live.motion.step_clip import StepClip
from live.show.background_work import short_switch_interval
from live.show.score.step_names import UnknownStep
from live.show.selection.graph_update import clip_key, clips_by_key, library_hash, steps_hash, updated_graph

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
        read: Callable[[], TempoForms],
    ) -> None:
        """`offer` passes on a graph with its hash, `post` the event that activates it, at the time `now()`.

        `read` returns all clips as at a start, and which steps fit no tempo of the show.
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

    def adopt(self, graph: MotionGraph, clips: Iterable[StepClip]) -> None:
        """Go on from a graph that was offered by other ways; `clips` of it are those that the folder now holds."""
        self.graph = graph
        self._known.update(clips_by_key(clips))

    def poll(self) -> bool:
        """Poll once. Returns whether clips were added, changed or removed."""
        stamp = folder_stamp(self._folder)
        settled, self._last_stamp = stamp == self._last_stamp, stamp
        if not settled or stamp == self._handled_stamp:
            return False
        self._handled_stamp = stamp
        try:
            with short_switch_interval():
                formed = self._read()
                self.problem = "".join(f"new steps: {why}" for why in formed.refused.values())
                return self._update(formed.clips)
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


def added_event(clips: Sequence[StepClip], graph: MotionGraph, now: Callable[[], float]) -> StepsChanged:
    """Return the event that brings clips, as they are, into the show at once; `graph` has them. ValueError if it would
    be too long. `now()` is its time."""
    text = clips_to_text(clips)
    if len(text) > MAX_EVENT_CHARACTERS:
        raise ValueError(f"{step_list(clips)}: too long for a running show")
    return StepsChanged(time=now(), source="learn", gone="", was="", now=text, library=steps_hash(graph), at_once=True)


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
