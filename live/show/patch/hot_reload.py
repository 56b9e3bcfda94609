"""PatchWatch: a thread that sees the files of a patch change while its show runs, proves the new patch and offers it.

The thread reads the files, checks them, and builds a whole fresh show of them: what does not start there is told and
never reaches the stage, where the last good patch goes on. Only then the event is posted that the show acts on.
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
"""Seconds between two looks at the files; they must look the same twice, so that nothing half written is read."""
STEPS_EVERY: Final = 20
"""Looks from one at the steps to the next: recordings are long files, and are written slowly."""
LONGEST: Final = 2_000_000
"""Characters of a packed patch at most: more than 20,000 entries take."""


class PatchWatch:
    """Watches the files of one patch, and in the same thread (`library`) the folder of its steps."""

    def __init__(
        self,
        loaded: LoadedShow,
        show: Show,
        *,
        post: Callable[[ControlEvent], None],
        now: Callable[[], float],
        library: LibraryWatch | None = None,
    ) -> None:
        """`post` takes the event that calls for the new patch, at the time `now()`."""
        self._loaded, self._show, self._post, self._now = loaded, show, post, now
        self._library = library
        self._patch, self._graph = show.patch, show.graph
        self._text = written_text(self._patch)
        self._asked = self._patch  # as it was written last, with what waits for the next start
        if library is not None:
            library.prove = lambda graph: show.another(self._patch, graph)
        self._seen = self._taken = stamp_of_files(loaded.path)
        self._failed, self._over = 0, (0, 0)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="patch watch", daemon=True)
        self.version = version_of(self._text)
        """The patch that was offered last; at first the one that the show began with."""
        self.problem = ""
        """Why the last edit could not be taken; empty if it could."""
        self.told = ""
        """What the last edit changes, and what of it waits for a new start, in words; empty before."""
        self.waits: tuple[str, ...] = ()
        """Keys of the last edit that wait for a new start."""

    def start(self) -> None:
        """Begin to watch."""
        self._thread.start()

    def stop(self) -> None:
        """End, and wait for what is being read."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join(timeout=10.0)

    def facts(self) -> dict[str, Any]:
        """For the status: which patch is in force, what is wrong with the last edit, what waits for a new start."""
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
        """Free what is left over of patches that were tried or taken: shows, in circles. To be called after `look`."""
        over = self._failed, self._show.reloading.taken
        if over != self._over:
            self._over = over
            freed(self._show.reloading.spent)
            gc.collect()

    def look(self, *, steps: bool = True) -> bool:
        """Look once, at the `steps` as well or not; True if a patch was offered."""
        joined = steps and self._library is not None and self._library.look()
        stamp = stamp_of_files(self._loaded.path)
        settled, self._seen = stamp == self._seen, stamp
        again = joined and bool(self.problem)  # the step that it names may have come now
        if not (settled and stamp != self._taken) and not again:
            return False
        self._taken = stamp
        try:
            with polite():
                return self._read()
        except (PersonError, OSError) as error:
            self.problem = f"patch: {error}; the last good one goes on"
            return False
        except Exception as error:  # the program's own fault: the watch goes on, and whoever saved it is told
            FAULTS.note("the reader of the patch", error)
            self.problem = f"patch: it cannot be taken ({type(error).__name__}: {error}); the last good one goes on"
            return False

    def _read(self) -> bool:
        """Read, prove and offer what stands in the files now."""
        graph = self._graph if self._library is None else self._library.graph
        patch, sources = read_sources(self._loaded.path)
        patch = patch_for(patch, graph, self._patch, recordings=self._loaded.recordings is not None)
        patch = in_hall(patch, self._loaded.projector)
        self._check_files(patch, sources)
        patch, self.waits = fitted(patch, self._patch)
        text = written_text(patch)
        if text == self._text:  # only what has to wait, comments, or back to what it was
            mended, self.problem = bool(self.problem), ""
            self._tell((), sources)
            if mended and not self.told:
                self.told = "patch: mended; it says what is danced already"
            return False
        if len(packed(text)) > LONGEST:
            raise PersonError("the patch is too long to be taken while the show runs")
        if patch.picture.own != self._patch.picture.own:
            try_passes(patch.picture.own_passes)
        prepared = self._proved(text, graph, sources)
        walk_ahead(prepared.fresh.patch, "patch")  # for snapshots
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
        """PersonError for a file that the next start would refuse: it is told now, when somebody looks."""
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
    """A key in words as the path to it: "group.1.dancers"."""
    return tuple(int(part) - 1 if part.isdecimal() else part for part in key.split("."))


def stamp_of_files(path: Path) -> Stamp:
    """Names, times and sizes of the files of a patch: it changes when they do."""
    rows = []
    try:
        for file in (*patch_files(path), *own_pass_files(path)):
            facts = file.stat()
            rows.append((str(file), facts.st_mtime_ns, facts.st_size))
    except (OSError, PersonError):  # it is being moved: look again later
        return ()
    return tuple(rows)
