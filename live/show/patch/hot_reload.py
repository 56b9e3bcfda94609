"""Hot reload of a patch: a thread watches its files, validates an edit and offers it to the running show.

The thread reads and checks the files and builds a whole new show from them. An edit that fails there is reported and
never reaches the stage; the last good patch stays in force. Only a patch that starts is posted as an event.
"""

import gc
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from live.base.compression import packed
from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS, keep_running
from live.control.events.events import ControlEvent, PatchChanged
from live.graph.motion_graph import MotionGraph
from live.render.custom_pass import try_passes
from live.show.background_work import freed, polite, written_text
from live.show.dancers.character_casting import check_characters
from live.show.loader import LoadedShow, patch_for, told_with_place
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import TomlSources, field_words, own_pass_files, patch_files, read_sources
from live.show.patch.patch_update import Prepared, fitted, prepare, version_of
from live.show.selection.graph_update import LibraryWatch, Stamp
from live.show.show import Show
from live.show.state.constants import walk_ahead
from live.show.venue.venue_output import in_hall
from live.show.view.render_scene import backgrounds_of

POLL_S: Final = 0.05
"""Seconds between two polls; two equal polls are required, so that no half-written file is read."""
STEPS_EVERY: Final = 20
"""The step folder is polled once in this many polls: recordings are long files that take long to write."""
LONGEST: Final = 2_000_000
"""Largest length of a packed patch [characters]; enough for more than 20,000 entries."""


class PatchWatch:
    """Watches the files of one patch and, with `library`, its step folder in the same thread."""

    def __init__(
        self,
        loaded: LoadedShow,
        show: Show,
        *,
        post: Callable[[ControlEvent], None],
        now: Callable[[], float],
        library: LibraryWatch | None = None,
    ) -> None:
        """`post` receives the event that requests the new patch, with the time `now()`."""
        self._loaded, self._show, self._post, self._now = loaded, show, post, now
        self._library = library
        self._patch, self._graph = show.patch, show.graph
        self._text = written_text(self._patch)
        self._asked = self._patch  # as last written, including keys that wait for the next start
        if library is not None:
            library.prove = lambda graph: show.another(self._patch, graph)
        self._seen = self._taken = stamp_of_files(loaded.path)
        self._failed, self._over = 0, (0, 0)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="patch watch", daemon=True)
        self.version = version_of(self._text)
        """Version of the patch that was offered last; at first that of the patch the show began with."""
        self.problem = ""
        """Why the last edit was refused; empty if it was accepted."""
        self.told = ""
        """Message on what the last edit changes and which keys wait for a new start; empty before the first edit."""
        self.waits: tuple[str, ...] = ()
        """Keys of the last edit that take effect only after a new start."""

    def start(self) -> None:
        """Start the watching thread."""
        self._thread.start()

    def stop(self) -> None:
        """Stop the thread and wait until its current read has ended."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join(timeout=10.0)

    def facts(self) -> dict[str, Any]:
        """Return status values: the patch in force, the last edit's problem, and keys that wait for a new start."""
        return {"version": self.version, "problem": self.problem, "waits": list(self.waits)}

    def _run(self) -> None:
        keep_running("the watch of the patch", self._watch, self._ended.wait)

    def _watch(self) -> None:
        turn = 0
        while not self._ended.wait(POLL_S):
            turn += 1
            self.look(steps=turn % STEPS_EVERY == 0)
            self.tidy()

    def tidy(self) -> None:
        """Free the shows of patches that were tried or replaced (they hold reference cycles). Call after `look`."""
        over = self._failed, self._show.reloading.taken
        if over != self._over:
            self._over = over
            freed(self._show.reloading.spent)
            gc.collect()

    def look(self, *, steps: bool = True) -> bool:
        """Poll the files once, with `steps` the step folder too; return True if a patch was offered."""
        joined = steps and self._library is not None and self._library.look()
        stamp = stamp_of_files(self._loaded.path)
        settled, self._seen = stamp == self._seen, stamp
        again = joined and bool(self.problem)  # the step that the problem names may exist now
        if not (settled and stamp != self._taken) and not again:
            return False
        self._taken = stamp
        try:
            with polite():
                return self._read()
        except (PersonError, OSError) as error:
            self.problem = f"patch: {error}; the last good one goes on"
            return False
        except Exception as error:  # a fault of the program: keep watching, and report it to the author of the edit
            FAULTS.note("the reader of the patch", error)
            self.problem = f"patch: it cannot be taken ({type(error).__name__}: {error}); the last good one goes on"
            return False

    def _read(self) -> bool:
        """Read, validate and offer the current files."""
        graph = self._graph if self._library is None else self._library.graph
        patch, sources = read_sources(self._loaded.path)
        patch = patch_for(patch, graph, self._patch, recordings=self._loaded.recordings is not None)
        patch = in_hall(patch, self._loaded.projector)
        self._check_files(patch, sources)
        patch, self.waits = fitted(patch, self._patch)
        text = written_text(patch)
        if text == self._text:  # only comments or keys that wait changed, or the edit was undone
            mended, self.problem = bool(self.problem), ""
            self._tell((), sources)
            if mended and not self.told:
                self.told = "patch: mended; it is the same as the patch in force"
            return False
        if len(packed(text)) > LONGEST:
            raise PersonError("the patch is too long to be taken while the show runs")
        if patch.picture.own != self._patch.picture.own:
            try_passes(patch.picture.own_passes)
        prepared = self._proved(text, graph, sources)
        walk_ahead(prepared.fresh.patch, "patch")  # snapshots need this
        self._text, self._patch, self._graph, self.version = text, patch, prepared.fresh.graph, prepared.version
        if self._library is not None:
            self._library.graph = prepared.fresh.graph
            self._library.again()
        self.problem = ""
        self._show.offer_patch(prepared)
        self._post(PatchChanged(time=self._now(), source="patch", patch=packed(text), version=prepared.version))
        self._tell(prepared.different, sources)
        return True

    def _check_files(self, patch: Patch, sources: TomlSources) -> None:
        """Raise PersonError for a file that the next start would refuse, so that the author hears of it now."""
        with told_with_place(sources):
            if patch.character != self._asked.character:
                check_characters(patch, self._loaded.path)
            if patch.background != self._asked.background:
                backgrounds_of(patch, self._loaded.path)
        self._asked = patch

    def _proved(self, text: str, graph: MotionGraph, sources: TomlSources) -> Prepared:
        try:
            return prepare(text, self._show.another, self._patch, graph)
        except PersonError as error:
            self._failed += 1
            where = f"{sources.told(error.place)}: {field_words(error.place)}: " if error.place else ""
            raise PersonError(f"{where}{error.message}", error.remedy) from None

    def _tell(self, different: tuple[str, ...], sources: TomlSources) -> None:
        words = [f"patch: new from the next measure on: {', '.join(different)}"] if different else []
        if self.waits:
            where = sources.told(_place(self.waits[0]))
            words.append(f"from the next start on (e.g. {where}): {', '.join(self.waits)}")
        self.told = "; ".join(words)


def _place(key: str) -> tuple[str | int, ...]:
    """Path of a key that is written as in "group.1.dancers"."""
    return tuple(int(part) - 1 if part.isdecimal() else part for part in key.split("."))


def stamp_of_files(path: Path) -> Stamp:
    """Names, modification times and sizes of the files of a patch."""
    rows = []
    try:
        for file in (*patch_files(path), *own_pass_files(path)):
            facts = file.stat()
            rows.append((str(file), facts.st_mtime_ns, facts.st_size))
    except (OSError, PersonError):  # the files are being moved: the next poll reads them
        return ()
    return tuple(rows)
