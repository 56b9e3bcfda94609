"""A journalled show of a folder of its own, whose files are edited while it runs, driven by hand."""

import shutil
from pathlib import Path

from live.base.event_queue import EventQueue
from live.clock.time_source import ManualClock
from live.control.events.event import ControlEvent
from live.show.engine import Engine
from live.show.journal.journal import JournalWriter
from live.show.loader import load_show
from live.show.patch.patch_search_path import PATCHES
from live.show.selection.graph_update import LibraryWatch
from live.show.view.status import Status
from tests.show.journal.disk import settled

STEPS = PATCHES / "steps"


def folder_with(folder: Path, text: str) -> Path:
    """The patch `text` in a folder with two steps of its own, in `moves`; others come from the project."""
    (folder / "moves").mkdir()
    for name in ("groove", "side_step"):
        shutil.copy(STEPS / f"{name}.toml", folder / "moves")
    (folder / "show.toml").write_text(text)
    return folder / "show.toml"


class Night:
    """The show with its journal, and a watch on its steps."""

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
            offer=self.show.offer_graph,
            post=self.inbox.put,
            now=self.clock.now,
        )
        self._frame = 0

    def run(self, seconds: float) -> dict[int, set[str]]:
        """So many seconds of the show; the steps danced in each measure that it comes to, by its number from 1."""
        danced: dict[int, set[str]] = {}
        for _ in range(round(seconds * 50)):
            self._frame += 1
            self.clock.set(self._frame / 50)
            self.engine.frame(lambda view: None)
            if self._frame % 50 == 0:
                settled(self.writer)
            danced.setdefault(self.show.span.number + 1, set()).update(self.names())
        return danced

    def names(self) -> set[str]:
        """The steps that are danced now."""
        library = self.show.graph.library
        return {library.steps[s] for s in library.node_step[self.show.dancers.node]}
