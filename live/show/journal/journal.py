"""Journal of a show: patch, seed and every event with its tick, one JSON object per line (T148, T150).

Format 2: a header, then events before they are applied and a state hash at each measure line. Snapshots are stored in a
second file (`journal_writer.py`). The show never waits for the disk: lost lines are counted and reported.
"""

import json
from collections.abc import Mapping
from dataclasses import MISSING, fields
from functools import cache
from pathlib import Path
from typing import Any, Final, Protocol

from live import __version__
from live.clock.ticks import TICK
from live.control.events.event import ControlEvent
from live.control.events.event_json import IN_ROWS, columns_of, event_to_json, event_to_row
from live.control.events.events import EVENT_TYPES
from live.show.journal.journal_reader import (
    FORMAT,
    Journal,
    JournalError,
    JournalLine,
    read_journal,
)
from live.show.journal.journal_writer import SNAPSHOT_SUFFIX, JournalFile, move_aside
from live.show.show import Show
from live.show.state.snapshot import CapturedSnapshot, SnapshotPolicy

__all__ = [
    "FORMAT",
    "Journal",
    "JournalError",
    "JournalLine",
    "JournalSink",
    "JournalWriter",
    "event_line",
    "move_aside",
    "read_journal",
]


REPORTED_BACKLOG: Final = 1024
"""Number of waiting lines from which on a slow disk is reported."""


class JournalSink(Protocol):
    """Destination of a journal: a file, or a pipe to another process. No method blocks."""

    def put(self, line: str) -> None:
        """Accept one line, without its line break."""
        ...

    def snapshot(self, taken: CapturedSnapshot) -> None:
        """Accept a snapshot; the sink seals it."""
        ...

    def facts(self) -> dict[str, int]:
        """Return figures for the status: lines accepted and dropped, bytes written, waiting lines (behind), lines lost
        since the last one written (missing), snapshots written."""
        ...

    def close(self) -> None:
        """Write all waiting lines and close."""
        ...


class JournalWriter:
    """Records the events and measures of a show; a sink writes the lines. Thread: all methods from the show's."""

    def __init__(
        self, path: Path, header: dict[str, Any] | None, *, sink: JournalSink | None = None, snapshots: bool = True
    ) -> None:
        """`header`: data needed for a replay; None: an existing journal is continued. Raises JournalError if the file
        cannot be created.

        `sink`: destination instead of a file at `path`. `snapshots`: whether snapshots are taken.
        """
        self.older_journal: Path | None = None
        """New path of an older journal of the same name; None if there was none."""
        if sink is None:
            try:
                self.older_journal = move_aside(path)
                sink = JournalFile(path, path.with_name(path.name + SNAPSHOT_SUFFIX))
            except OSError as error:
                raise JournalError(f"cannot write the journal {path}: {error.strerror}") from None
        self.sink = sink
        self._snapshots = SnapshotPolicy(sink.snapshot) if snapshots else None
        if header is not None:
            columns = {kind.__name__: columns_of(kind) for kind in IN_ROWS}
            facts = {"version": __version__, "ticks_per_second": round(1 / TICK), "columns": columns}
            self._put({"journal": FORMAT, **facts, **header})

    @property
    def dropped(self) -> int:
        """Lines lost because the disk did not keep up or refused them."""
        return self.sink.facts()["dropped"]

    def record_event(self, tick: int, event: ControlEvent) -> None:
        """Record an event that acts from the tick after `tick` on."""
        self.sink.put(event_line(tick, event))

    def record_measure(self, tick: int, measure: int, state: str) -> None:
        """Record the state hash at the first tick of a measure (measures from 1)."""
        self._put({"tick": tick, "measure": measure, "hash": state})

    def prepare(self, show: Show) -> None:
        """Prepare for snapshots of this show; takes some milliseconds, so call it before the show begins."""
        if self._snapshots is not None:
            self._snapshots.prepare(show)

    def take_snapshot(self, show: Show, tick: int, *, begins: bool) -> None:
        """Take a snapshot of each measure, some ticks after its line; `begins`: the measure began with this tick."""
        if self._snapshots is not None:
            self._snapshots.after_tick(show, tick, begins=begins)

    def facts(self) -> dict[str, int]:
        """Return figures for the status, see `JournalSink.facts`."""
        failed = {} if self._snapshots is None else {"snapshots_failed": self._snapshots.failed}
        return self.sink.facts() | failed

    @property
    def problem(self) -> str:
        """The current problem, for the operator; empty if there is none. Counts in it change only by factors of two."""
        if trouble := disk_problem(self.facts()):
            return trouble
        if self._snapshots is not None and self._snapshots.problem:
            return f"journal: {self._snapshots.problem}"
        return ""

    def close(self, tick: int, *, ended: bool = True, seconds: float | None = None) -> None:
        """Record the last tick if the show has `ended`, write all waiting lines and close.

        `seconds`: exact length of a show that was rendered as a film.
        """
        if ended:
            self._put({"tick": tick, "end": True} | ({} if seconds is None else {"seconds": seconds}))
        self.sink.close()

    def _put(self, line: dict[str, Any]) -> None:
        self.sink.put(_compact(line))


def disk_problem(facts: Mapping[str, int]) -> str:
    """Describe the disk problem in `JournalSink.facts`, in words that change seldom; empty if there is none."""
    if dropped := facts.get("dropped", 0):
        if facts.get("missing", dropped):
            return f"journal: {_rounded(dropped)} lines could not be written: is the disk full?"
        return f"journal: {_rounded(dropped)} lines are missing; writing works again"
    if facts.get("behind", 0) >= REPORTED_BACKLOG:
        return f"journal: the disk is {_rounded(facts['behind'])} lines behind"
    return ""


def _rounded(count: int) -> str:
    """Return a count rounded down to a power of two, in words."""
    return str(count) if count < 2 else f"{1 << (count.bit_length() - 1)} or more"


def event_line(tick: int, event: ControlEvent) -> str:
    """Return the line of an event that acts from the tick after `tick` on, without default values."""
    if isinstance(event, IN_ROWS):
        return _compact({"tick": tick, "event": event_to_row(event)})
    usual = _defaults(type(event).__name__)
    values = {key: value for key, value in event_to_json(event).items() if usual.get(key, MISSING) != value}
    return _compact({"tick": tick, "event": values})


@cache
def _defaults(name: str) -> dict[str, Any]:
    return {field.name: field.default for field in fields(EVENT_TYPES[name]) if field.default is not MISSING}


def _compact(line: dict[str, Any]) -> str:
    return json.dumps(line, separators=(",", ":"))
