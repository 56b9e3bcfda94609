"""Hot reload of a patch: a thread watches its files, validates an edit and offers it to the running show.

The thread reads and checks the files and builds a whole new show from them. An edit that fails there is reported and
never reaches the stage; the last good patch stays in force. Only a patch that starts is posted as an event.
"""

import gc
import queue
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final

from live.base.compression import compress_text
from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS
from live.control.events.events import ControlEvent, LearningFailed, PatchChanged
from live.control.worker_thread import WorkerThread
from live.graph.library_insert import stranded
from live.render.custom_pass import try_passes
from live.show.background_work import short_switch_interval
from live.show.capture.danced_poses import Take
from live.show.capture.learnt_step import learn_step, save_step
from live.show.dancers.character_casting import check_characters
from live.show.group.stage_check import refusal, stage_faults
from live.show.loader import LoadedShow, adapt_edited_patch
from live.show.partner.example_updates import ExamplesWatch
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import custom_pass_files, patch_files, read_sources
from live.show.patch.patch_update import PreparedPatch, changed_fields, fresh_show, patch_version, split_deferred
from live.show.patch.table_batches import free_patches, patch_json
from live.show.patch.toml_model import TomlSources, key_text
from live.show.selection.library_watch import LibraryWatch, Stamp, added_event
from live.show.show import Show
from live.show.state.constants import walk_ahead
from live.show.venue.venue_output import with_venue_projector
from live.show.view.render_scene import make_backgrounds, make_scenery

POLL_S: Final = 0.05
"""Seconds between two polls; two equal polls are required, so that no half-written file is read."""
LIBRARY_POLL_INTERVAL: Final = 20
"""The step folder is polled once in this many polls: recordings are long files that take long to write."""
MAX_PACKED_CHARS: Final = 2_000_000
"""Largest length of a packed patch [characters]; enough for more than 20,000 entries."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """An edited patch that the running show can take."""

    written: Patch
    """The patch as it was written."""
    patch: Patch
    """The patch as far as it acts before the next start."""
    deferred_keys: tuple[str, ...]
    """The keys that wait for the next start."""
    new_show: Any
    """A show of it, which is not run; None if nothing changes before the next start."""


class PatchWatch:
    """Watches the files of one patch and, with `library` and `examples`, its step folder and its files of pairs in the
    same thread."""

    def __init__(
        self,
        loaded: LoadedShow,
        show: Show,
        *,
        post: Callable[[ControlEvent], None],
        now: Callable[[], float],
        library: LibraryWatch | None = None,
        examples: ExamplesWatch | None = None,
    ) -> None:
        """`post` receives the event that requests the new patch, with the time `now()`."""
        self._loaded, self._show, self._post, self._now = loaded, show, post, now
        self._library, self._examples = library, examples
        self._patch, self._graph = show.patch, show.graph
        self._last_written = self._patch  # as last written, including keys that wait for the next start
        if library is not None:
            library.check = lambda graph: show.hot_swap.make_show(self._patch, graph)
        self._last_stamp = self._handled_stamp = file_stamp(loaded.path)
        self._failure_count, self._freed_counts = 0, (0, 0)
        self._turn = 0
        self._takes: list[Take] = []
        self.learnt = ""
        """What became of the last step that was learnt; empty before the first."""
        self.keeps_learnt = True
        """Whether learnt steps are written to the folder of steps."""
        self._worker = WorkerThread("patch watch", self._work, part="the watch of the patch")
        self._tasks: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self.version = patch_version(patch_json(self._patch))
        """Version of the patch that was offered last; at first that of the patch the show began with."""
        self.problem = ""
        """Why the last edit was refused; empty if it was accepted."""
        self.message = ""
        """Message on what the last edit changes and which keys wait for a new start; empty before the first edit."""
        self.deferred_keys: tuple[str, ...] = ()
        """Keys of the last edit that take effect only after a new start."""

    def start(self) -> None:
        """Start the watching thread."""
        self._worker.start()

    def stop(self) -> None:
        """Stop the thread and wait until its current read has ended."""
        self._worker.stop(timeout=10.0)

    def status(self) -> dict[str, Any]:
        """Return status values: the patch in force, the last edit's problem, and keys that wait for a new start."""
        return {"version": self.version, "problem": self.problem, "waits": list(self.deferred_keys)}

    def do(self, task: Callable[[], None]) -> None:
        """Run a task soon in the watching thread, between two polls. Thread: any."""
        self._tasks.put(task)

    def frame(self) -> None:
        """Begin to learn what performers have danced for that, in the watching thread. Thread: the show's."""
        takes = self._show.seen_steps.takes
        if takes or self._takes:
            self._takes = [take for take in self._takes if take in takes]
            for take in takes:
                if take.is_over and take not in self._takes:
                    self._takes.append(take)
                    self.do(partial(self.learn, take))

    def learn(self, take: Take) -> None:
        """Make a step of a take, have the show take it, and keep it in the folder of steps. Thread: the watching one,
        or before it starts."""
        folder = self._loaded.steps_folder
        graph = self._graph if self._library is None else self._library.graph
        try:
            with short_switch_interval():
                step = learn_step(take, graph, self._patch, self._loaded.tempo.span(self._patch), folder)
                event = added_event(step.clips, step.graph, self._now)
        except (PersonError, ValueError, OSError) as error:
            self._fail(take, str(error))
            return
        except Exception as error:  # a bug: keep watching, and report it
            FAULTS.record("the learning of a step", error)
            self._fail(take, f"{type(error).__name__}: {error}")
            return
        self._show.hot_swap.offer_graph(event.library, step.graph)
        self._post(event)
        self._graph = step.graph
        lost = save_step(step, folder) if self.keeps_learnt else "--no-record"
        if self._library is not None:
            self._library.adopt(step.graph, step.clips if not lost and step.fits_tempo else ())
        self.learnt = f"learnt: {take.name} can be danced"
        if lost:
            self.learnt += f", but is not kept: {lost}"
        elif not step.fits_tempo:
            self.learnt += "; at the tempo of the patch the next start will leave it out"

    def _fail(self, take: Take, reason: str) -> None:
        self._post(
            LearningFailed(time=self._now(), source="learn", performer=take.performer, name=take.name, reason=reason)
        )

    def _work(self) -> None:
        while not self._worker.stopping.is_set():
            try:
                task = self._tasks.get(timeout=POLL_S)
            except queue.Empty:
                self._watch()
                continue
            task()
            self.run_tasks()
            self.free_replaced()

    def run_tasks(self) -> None:
        """Run the tasks that wait. Thread: the watching one, or before it starts."""
        while not self._tasks.empty():
            self._tasks.get()()

    def _watch(self) -> None:
        self._turn += 1
        self.poll(with_library=self._turn % LIBRARY_POLL_INTERVAL == 0)
        self.free_replaced()

    def free_replaced(self) -> None:
        """Free the shows of patches that were tried or replaced (they hold reference cycles). Call after `poll`."""
        over = self._failure_count, self._show.patch_updates.applied_count
        if over != self._freed_counts:
            self._freed_counts = over
            free_patches(self._show.patch_updates.replaced)
            gc.collect()

    def poll(self, *, with_library: bool = True) -> bool:
        """Poll the files once, with `with_library` the step folder too; return True if a patch was offered."""
        if with_library and self._examples is not None:
            self._examples.poll(self._patch)
        joined = with_library and self._library is not None and self._library.poll()
        stamp = file_stamp(self._loaded.path)
        settled, self._last_stamp = stamp == self._last_stamp, stamp
        again = joined and bool(self.problem)  # the step that the problem names may exist now
        if not (settled and stamp != self._handled_stamp) and not again:
            return False
        self._handled_stamp = stamp
        try:
            with short_switch_interval():
                return self._reload()
        except (PersonError, OSError) as error:
            self.problem = f"patch: {error}; the last good one goes on"
            return False
        except Exception as error:  # a fault of the program: keep watching, and report it to the author of the edit
            FAULTS.record("the reader of the patch", error)
            self.problem = f"patch: it cannot be taken ({type(error).__name__}: {error}); the last good one goes on"
            return False

    def _reload(self) -> bool:
        """Read, check and offer the current files."""
        patch, sources = read_sources(self._loaded.path, self._loaded.tables)
        try:
            candidate = self.candidate(patch)
            faults = [] if candidate.new_show is None else stage_faults(candidate.new_show, self._patch)
            if faults:
                raise refusal(faults)
        except PersonError as error:
            self._failure_count += 1
            where = f"{sources.location_text(error.key_path)}: {key_text(error.key_path)}: " if error.key_path else ""
            raise PersonError(f"{where}{error.message}", error.remedy) from None
        return self.offer(candidate, sources)

    def candidate(self, written: Patch) -> Candidate:
        """Return an edited patch ready for the running show; PersonError, with its place, if the show cannot take it.

        Thread: the watching one, or before it starts.
        """
        graph = self._graph if self._library is None else self._library.graph
        patch = adapt_edited_patch(written, graph, self._patch, recordings=self._loaded.recordings is not None)
        if self._loaded.in_venue:
            patch = with_venue_projector(patch, self._loaded.projector)
        self._check_files(patch)
        whole = patch
        patch, waits = split_deferred(patch, self._patch)
        if patch == self._patch:
            return Candidate(whole, self._patch, waits, None)
        if patch.picture.own != self._patch.picture.own:
            try_passes(patch.picture.own_passes)
        new_show = fresh_show(patch, self._show.hot_swap.make_show, self._patch, graph)
        if new_show.graph is not graph and stranded(new_show.graph, self._show.dancers.node).any():
            raise PersonError("[locomotion] would leave dancers without a next step", "a larger threshold_m")
        return Candidate(whole, patch, waits, new_show)

    def offer(self, candidate: Candidate, sources: TomlSources) -> bool:
        """Have the show take a candidate from the next measure that is not planned yet; return False if nothing
        changes. PersonError if it is too long. `sources` are its texts, for messages. Thread: as for `candidate`."""
        self._last_written, self.deferred_keys = candidate.written, candidate.deferred_keys
        if candidate.new_show is None:  # only comments or keys that wait changed, or the edit was undone
            mended, self.problem = bool(self.problem), ""
            self._set_message((), sources)
            if mended and not self.message:
                self.message = "patch: mended; it is the same as the patch in force"
            return False
        text = patch_json(candidate.patch)
        packed = compress_text(text)
        if len(packed) > MAX_PACKED_CHARS:
            raise PersonError("the patch is too long to be taken while the show runs")
        walk_ahead(candidate.patch, "patch")  # snapshots need this
        changed = changed_fields(self._patch, candidate.patch)
        prepared = PreparedPatch(patch_version(text), candidate.new_show, changed)
        self._patch, self._graph, self.version = candidate.patch, candidate.new_show.graph, prepared.version
        if self._library is not None:
            self._library.graph = self._graph
            self._library.retry()
        self.problem = ""
        self._show.hot_swap.offer_patch(prepared)
        self._post(PatchChanged(time=self._now(), source="patch", patch=packed, version=prepared.version))
        self._set_message(changed, sources)
        return True

    def skip_present_files(self) -> None:
        """Take the present files as read: their patch was offered by other ways. Thread: as for `candidate`."""
        self._last_stamp = self._handled_stamp = file_stamp(self._loaded.path)

    def _check_files(self, patch: Patch) -> None:
        """Raise PersonError for a file that the next start would refuse, so that the author hears of it now."""
        if patch.character != self._last_written.character:
            check_characters(patch, self._loaded.path)
        if patch.background != self._last_written.background:
            make_backgrounds(patch, self._loaded.path)
        if patch.scenery != self._last_written.scenery:
            make_scenery(patch, self._loaded.path)
        if patch.takes != self._last_written.takes:
            self._loaded.check_takes(patch)

    def _set_message(self, different: tuple[str, ...], sources: TomlSources) -> None:
        words = [f"patch: new from the next measure on: {', '.join(different)}"] if different else []
        if self.deferred_keys:
            where = sources.location_text(_key_path(self.deferred_keys[0]))
            words.append(f"from the next start on (e.g. {where}): {', '.join(self.deferred_keys)}")
        self.message = "; ".join(words)


def _key_path(key: str) -> tuple[str | int, ...]:
    """Path of a key that is written as in "group.1.dancers"."""
    return tuple(int(part) - 1 if part.isdecimal() else part for part in key.split("."))


def file_stamp(path: Path) -> Stamp:
    """Names, modification times and sizes of the files of a patch."""
    rows = []
    try:
        for file in (*patch_files(path), *custom_pass_files(path)):
            facts = file.stat()
            rows.append((str(file), facts.st_mtime_ns, facts.st_size))
    except (OSError, PersonError):  # the files are being moved: the next poll reads them
        return ()
    return tuple(rows)
