"""Minimiser for failing journals: reduces hours of a soak test to a test of a second, by delta debugging.

Uses ddmin (Zeller and Hildebrandt 2002). A journal fails if a tick or an event raises an exception, or if the show
restored from a snapshot reaches another state than the continuous run. The result must fail in the same way. It has no
state hashes, as those belong to a failed show.
"""

import json
import time as _time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Final

from live.clock.ticks import TICK
from live.control.events.event import ControlEvent
from live.control.events.events import ExamplesChanged, PatchChanged, StepsAdded, StepsChanged, TicksSkipped
from live.rehearse.failure import DIFFERENT_STATE, Failure
from live.show.journal.journal import event_line
from live.show.journal.journal_reader import Journal, read_journal
from live.show.journal.replay import ReplayError, load_journal
from live.show.loader import LoadedShow, load_from_patch
from live.show.patch.patch import Patch
from live.show.patch.patch_search_path import MAIN_FILE, PATCHES
from live.show.patch_checks.patch_check import PATCH_CHECKS
from live.show.selection.graph_update import library_hash
from live.show.show import Show
from live.show.state.snapshot import Snapshotter, restore

Entry = tuple[int, ControlEvent]
"""An event, and the tick after which it was applied."""

CHANGE_EVENTS: Final = (PatchChanged, StepsAdded, StepsChanged, ExamplesChanged)
TIME_FIELDS: Final = ("time", "beat_time")
"""Fields of events that hold a time of the show [s]: they are shifted with the event."""
BREAKER_PREFIX: Final = "Breaker"
"""Name prefix of circuit breaker events. They are left out: otherwise the failing part stays disabled."""
TAIL_MEASURES: Final = (1, 2, 4, 8, 16, 32)
"""Numbers of measures before the failure that are tried as the whole journal."""


@dataclass(slots=True)
class MinimisedJournal:
    """A minimised journal."""

    header: dict[str, Any]
    entries: list[Entry]
    end: int
    """The tick after which it ends."""
    failure: Failure
    trial_count: int = 0
    original_size: tuple[int, int] = (0, 0)
    """Numbers of events and ticks of the original."""

    def write(self, path: Path) -> None:
        """Write it as a journal. Raises OSError."""
        kept = {key: value for key, value in self.header.items() if key not in ("origin", "begun")}
        kept["patch_path"] = _portable_path(Path(str(self.header["patch_path"])), str(self.header["patch"].get("name")))
        kept["fails"] = {"kind": self.failure.kind, "place": self.failure.place, "words": self.failure.message}
        lines = [json.dumps(kept, separators=(",", ":"))]
        lines += [event_line(tick, event) for tick, event in self.entries]
        lines.append(json.dumps({"tick": self.end, "end": True}, separators=(",", ":")))
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")


class Trial:
    """Runs entries from the beginning of a show and returns the failure."""

    def __init__(self, loaded: LoadedShow, header: dict[str, Any], *, snapshots: bool = False) -> None:
        """`snapshots`: also run from a snapshot in the middle, and compare the final states."""
        self._loaded, self._header, self._snapshots = loaded, header, snapshots
        self.count = 0
        """Number of runs so far."""
        self.measure_ticks: list[int] = []
        """Ticks of the last run at which a measure began."""

    def run(self, entries: Sequence[Entry], end: int) -> Failure | None:
        """Run up to the tick `end`; return the failure, None if there is none."""
        self.count += 1
        self.measure_ticks = []
        tick = 0
        try:
            show = self._loaded.start(seed=self._header["seed"], tempo=self._header["tempo"])
            snapshot: tuple[int, bytes] | None = None
            for tick, begins in run_entries(show, entries, end):
                if begins:
                    self.measure_ticks.append(tick)
                if self._snapshots and snapshot is None and tick >= end // 2:
                    taken = Snapshotter(show).capture(tick)
                    snapshot = None if taken is None else (tick, taken.seal())
            if snapshot is None:
                return None
            return self._run_from_snapshot(*snapshot, entries, end, show.state_hash())
        except Exception as error:
            return Failure.from_exception(error, tick)

    def _run_from_snapshot(
        self, tick: int, data: bytes, entries: Sequence[Entry], end: int, wanted: str
    ) -> Failure | None:
        """Run the rest from a snapshot and compare the final state hash with `wanted`."""
        changes = [event for at, event in entries if at < tick and isinstance(event, CHANGE_EVENTS)]
        if changes:  # a snapshot of an edited patch cannot be restored with the original patch
            return None
        show = restore(self._loaded, data)
        left = [(at, event) for at, event in entries if at >= tick]
        for _ in run_entries(show, left, end, begin=tick):
            pass
        found = show.state_hash()
        return (
            None
            if found == wanted
            else Failure(DIFFERENT_STATE, f"{wanted} in a continuous run, {found} from a snapshot")
        )


def run_entries(show: Show, entries: Sequence[Entry], end: int, *, begin: int = 0) -> Iterator[tuple[int, bool]]:
    """Run a show from after the tick `begin`; yield each tick and whether a measure began with it. Raises the show's
    exceptions."""
    tick, coming = begin, iter(entries)
    following = next(coming, None)
    while tick < end:
        while following is not None and following[0] <= tick:
            show.apply(following[1])
            if isinstance(following[1], TicksSkipped):
                tick += following[1].count
            following = next(coming, None)
        tick += 1
        yield tick, show.tick(tick * TICK)


def entries_of(journal: Journal) -> tuple[list[Entry], int]:
    """Return all readable events of a journal, also those skipped after a failure, and its last tick."""
    found: list[Entry] = []
    last = 0
    for line in journal.lines_with_damage():
        last = max(last, line.tick)
        if line.event is not None and not type(line.event).__name__.startswith(BREAKER_PREFIX):
            found.append((line.tick, line.event))
    return found, last


def load_for_journal(journal: Journal) -> LoadedShow:
    """Load the patch and library of a journal. If steps have changed since, the present ones are used: a stored failure
    is one of the program, not of a step. Raises ReplayError if the show cannot be loaded any more."""
    path = PATCHES / str(journal.header.get("patch_path"))  # a stored journal names a patch of the project
    journal = replace(journal, header={**journal.header, "patch_path": str(path)})
    try:
        return load_journal(journal)
    except ReplayError as error:
        if "steps have changed" not in str(error):
            raise
    recordings = journal.header.get("recordings")
    return load_from_patch(
        Patch.model_validate(journal.header["patch"], context=PATCH_CHECKS),
        path,
        recordings=None if recordings is None else Path(recordings),
    )


def _portable_path(path: Path, name: str) -> str:
    """Return the patch path for a stored journal: relative to the project's patches if it is one, or a copy of one."""
    if path.is_relative_to(PATCHES):
        return str(path.relative_to(PATCHES))
    for own in (*PATCHES.glob(f"*/{MAIN_FILE}"), *PATCHES.glob("*.toml")):
        if f'name = "{name}"' in own.read_text(encoding="utf-8"):
            return str(own.relative_to(PATCHES))
    return str(path)


@dataclass(slots=True)
class Minimiser:
    """Shortens a journal within a time limit."""

    trial: Trial
    header: dict[str, Any]
    seconds: float = 600.0
    """Time limit in real time [s]; the shortest journal found by then is returned."""
    on_progress: Callable[[str], None] = lambda words: None
    beats: int = 4
    _deadline: float = 0.0
    _failure: Failure = field(default_factory=lambda: Failure("", ""))

    def run(self, entries: list[Entry], end: int) -> MinimisedJournal | None:
        """Return the shortest failing journal found; None if these entries do not fail."""
        self._deadline = _time.monotonic() + self.seconds
        failure = self.trial.run(entries, end)
        if failure is None:
            return None
        self._failure = failure
        before = len(entries), end
        lines = self.trial.measure_ticks
        if failure.tick > 0:
            end = failure.tick
        entries = [entry for entry in entries if entry[0] < end]
        self.on_progress(f"{failure}; {len(entries)} events in {end} ticks")
        entries, end = self._keep_tail(entries, end, lines)
        entries = self._reduce(entries, end)
        entries, end = self._keep_tail(entries, end, self._lines_of(entries, end))
        entries = self._reduce(entries, end)
        return MinimisedJournal(self.header, entries, end, self._failure, self.trial.count, before)

    def _fails(self, entries: list[Entry], end: int) -> bool:
        if _time.monotonic() > self._deadline:
            return False
        found = self.trial.run(entries, end)
        if found is None or found.key != self._failure.key:
            return False
        self._failure = found
        return True

    def _lines_of(self, entries: list[Entry], end: int) -> list[int]:
        self.trial.run(entries, end)
        return self.trial.measure_ticks

    def _keep_tail(self, entries: list[Entry], end: int, lines: list[int]) -> tuple[list[Entry], int]:
        """Try to keep only the last measures, shifted by whole measures to the beginning."""
        for keep in TAIL_MEASURES:
            if keep + 2 >= len(lines):
                break
            moved = lines[-1 - keep] - lines[0]
            shorter = [_shift(entry, moved) for entry in entries if entry[0] > moved]
            # the measure line may round to another tick; the last try adds a whole measure
            for add in (0, 1, 2, lines[-1] - lines[-2]):
                if self._fails(shorter, end - moved + add):
                    end = self._failure.tick if self._failure.tick > 0 else end - moved + add
                    self.on_progress(f"the last {keep} measures suffice: {len(shorter)} events in {end} ticks")
                    return shorter, end
        return entries, end

    def _reduce(self, entries: list[Entry], end: int) -> list[Entry]:
        """Remove as many events as possible (ddmin)."""
        end = end + 4  # without an event, a measure line may move by a tick
        parts = 2
        while len(entries) >= 1 and _time.monotonic() <= self._deadline:
            size = max(len(entries) // parts, 1)
            for begin in range(0, len(entries), size):
                left = entries[:begin] + entries[begin + size :]
                if self._fails(left, end):
                    entries, parts = left, max(parts - 1, 2)
                    self.on_progress(f"{len(entries)} events")
                    break
            else:
                if size == 1:
                    break
                parts = min(parts * 2, len(entries))
        return entries


def _shift(entry: Entry, ticks: int) -> Entry:
    tick, event = entry
    names = {each.name for each in fields(event)}
    times = {name: getattr(event, name) - ticks * TICK for name in TIME_FIELDS if name in names}
    return tick - ticks, replace(event, **times)


def minimise(
    path: Path, *, seconds: float = 600.0, on_progress: Callable[[str], None] = lambda words: None
) -> MinimisedJournal | None:
    """Return the shortest journal that fails like the one at `path`; None if that does not fail. Raises JournalError
    and ReplayError if it cannot be run."""
    journal = read_journal(path)
    loaded = load_for_journal(journal)
    entries, end = entries_of(journal)
    header = {**journal.header, "steps_hash": library_hash(loaded.graph.library)}
    trial = Trial(loaded, header)
    found = Minimiser(trial, header, seconds, on_progress).run(entries, end)
    if found is not None:
        return found
    return Minimiser(Trial(loaded, header, snapshots=True), header, seconds, on_progress).run(entries, end)
