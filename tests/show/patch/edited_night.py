"""A journaled show in a folder of its own: its files are edited while it runs on a manual clock."""

import shutil
from pathlib import Path

from live.base.event_queue import EventQueue
from live.clock.time_source import ManualClock
from live.control.events.event import ControlEvent
from live.show.engine import Engine
from live.show.journal.journal import JournalWriter
from live.show.loader import load_show
from live.show.patch.patch_search_path import PATCHES
from live.show.selection.library_watch import LibraryWatch
from live.show.view.status import Status
from tests.show.journal.disk import wait_until_written

STEPS = PATCHES / "steps"


def write_patch_folder(folder: Path, text: str) -> Path:
    """Writes the patch `text` to a folder with two steps of its own, in `moves`; other steps come from the project."""
    (folder / "moves").mkdir()
    for name in ("groove", "side_step"):
        shutil.copy(STEPS / f"{name}.toml", folder / "moves")
    (folder / "show.toml").write_text(text)
    return folder / "show.toml"


class JournaledShow:
    """A show with its journal and a watch on its step files."""

    def __init__(self, patch: Path) -> None:
        self.path, self.loaded = patch, load_show(patch)
        self.show, self.clock = self.loaded.start(), ManualClock()
        self.inbox: EventQueue[ControlEvent] = EventQueue()
        self.journal = patch.parent / "night.jsonl"
        self.writer = JournalWriter(self.journal, self.loaded.header(self.show, tempo=None))
        status = Status(self.show, rejected=dict, memory=lambda: 0.0)
        self.engine = Engine(self.show, clock=self.clock, inbox=self.inbox, status=status, journal=self.writer)
        assert self.loaded.steps_folder is not None
        self.library = LibraryWatch(
            self.loaded.steps_folder,
            self.show.graph,
            offer=self.show.hot_swap.offer_graph,
            post=self.inbox.put,
            now=self.clock.now,
            read=self.loaded.read_steps,
        )
        self._frame = 0

    def run(self, seconds: float) -> dict[int, set[str]]:
        """Runs the show for `seconds`; returns the steps danced in each measure, by its number from 1."""
        danced: dict[int, set[str]] = {}
        for _ in range(round(seconds * 50)):
            self._frame += 1
            self.clock.set(self._frame / 50)
            self.engine.frame(lambda view: None)
            if self._frame % 50 == 0:
                wait_until_written(self.writer)
            danced.setdefault(self.show.span.number + 1, set()).update(self.names())
        return danced

    def names(self) -> set[str]:
        """The current steps of all dancers."""
        library = self.show.graph.library
        return {library.steps[s] for s in library.node_step[self.show.dancers.node]}
