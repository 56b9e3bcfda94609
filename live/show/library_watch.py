"""LibraryWatch: a thread that sees new takes in a folder of steps and joins them to the graph of a running show."""

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Final

from live.base.errors import PersonError
from live.control.events import StepsAdded
from live.graph.insertion import insert_clips
from live.graph.motion_graph import MotionGraph
from live.motion.step_clip import StepClip
from live.show.load import clip_key, library_hash
from live.steps.step_folder import load_folder

POLL_S: Final = 1.0
"""Seconds between two looks at the folder; it must look the same twice, so that nothing half written is read."""
Stamp = tuple[tuple[str, int, int], ...]


class LibraryWatch:
    """Watches one folder. What is new there is read, measured against everything and joined in this thread; the show
    takes the new graph up at a measure line. Files that were changed or taken away count from the next start on.
    """

    def __init__(
        self,
        folder: Path,
        graph: MotionGraph,
        *,
        offer: Callable[[str, MotionGraph], None],
        post: Callable[[StepsAdded], None],
        now: Callable[[], float],
    ) -> None:
        """`offer` hands a graph over under its hash, `post` the event that calls for it, at the time `now()`."""
        self._folder = folder
        self.graph = graph
        """The graph that was offered last."""
        self._offer, self._post, self._now = offer, post, now
        self._known = {clip_key(clip) for clip in graph.library.clips}
        self._seen = self._taken = stamp_of(folder)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="library watch", daemon=True)
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
        while not self._ended.wait(POLL_S):
            self.look()

    def look(self) -> bool:
        """Look once; True if something was joined."""
        stamp = stamp_of(self._folder)
        settled, self._seen = stamp == self._seen, stamp
        if not settled or stamp == self._taken:
            return False
        self._taken = stamp
        try:
            clips = load_folder(self._folder)
        except (PersonError, OSError) as error:
            self.problem = f"new steps: {error}"
            return False
        self.problem = ""
        return self._join([clip for clip in clips if clip_key(clip) not in self._known])

    def _join(self, clips: list[StepClip]) -> bool:
        fitting = [clip for clip in clips if clip.beats_per_measure == self.graph.library.beats_per_measure]
        if len(fitting) < len(clips):
            names = ", ".join(sorted({clip.step for clip in clips if clip not in fitting}))
            beats = self.graph.library.beats_per_measure
            self.problem = f"new steps: {names[:100]} can be danced only in another show: this one has {beats} beats"
        if not fitting:
            return False
        self.graph = insert_clips(self.graph, fitting)
        keys = [clip_key(clip) for clip in fitting]
        self._known.update(keys)
        found = library_hash(self.graph.library)
        self.joined = f"new steps: {', '.join(sorted({clip.step for clip in fitting}))[:200]} can be danced"
        self._offer(found, self.graph)
        self._post(StepsAdded(time=self._now(), source="library", clips="\n".join(keys), library=found))
        return True


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
