"""Journal: patch, seed and every event with the tick at which it acts, one JSON object a line (T148, T150).

Format 2, in order: the header; events before they act; at each measure line a hash over the state. Beside it lie
snapshots (`journal_file.py`). The show never waits for the disk: what is lost is counted and told, and it goes on.
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
from live.show.journal.journal_writer import SNAPSHOTS, JournalFile, keep_aside
from live.show.show import Show
from live.show.state.snapshot import Keeping, Taken

__all__ = [
    "FORMAT",
    "Journal",
    "JournalError",
    "JournalLine",
    "JournalSink",
    "JournalWriter",
    "keep_aside",
    "line_of",
    "read_journal",
]


BEHIND: Final = 1024
"""So many lines that wait for the disk are told."""


class JournalSink(Protocol):
    """Where a journal goes: a file, or a pipe to another process. No method waits."""

    def put(self, line: str) -> None:
        """Take one line, without its end."""
        ...

    def snapshot(self, taken: Taken) -> None:
        """Take a snapshot; whoever writes it seals it."""
        ...

    def facts(self) -> dict[str, int]:
        """For the status: lines taken and dropped, bytes written, lines that wait (behind), lines lost
        since the last that was written (missing), snapshots written."""
        ...

    def close(self) -> None:
        """Write what waits and end."""
        ...


class JournalWriter:
    """Notes what enters the show; a sink writes the lines. Thread: all methods from the show's."""

    def __init__(
        self, path: Path, header: dict[str, Any] | None, *, sink: JournalSink | None = None, snapshots: bool = True
    ) -> None:
        """`header`: what is needed to run the show again; None: it is there already, and the journal goes on. Raises
        JournalError if the file cannot be made.

        With a `sink` that is where everything goes, and there is no file. `snapshots`: whether states are kept.
        """
        self.kept: Path | None = None
        """Where a journal of the same name was moved to; None if there was none."""
        if sink is None:
            try:
                self.kept = keep_aside(path)
                sink = JournalFile(path, path.with_name(path.name + SNAPSHOTS))
            except OSError as error:
                raise JournalError(f"cannot write the journal {path}: {error.strerror}") from None
        self.sink = sink
        self._keeping = Keeping(sink.snapshot) if snapshots else None
        if header is not None:
            columns = {kind.__name__: columns_of(kind) for kind in IN_ROWS}
            facts = {"version": __version__, "ticks_per_second": round(1 / TICK), "columns": columns}
            self._put({"journal": FORMAT, **facts, **header})

    @property
    def dropped(self) -> int:
        """Lines lost because the disk did not keep up or refused them."""
        return self.sink.facts()["dropped"]

    def event(self, tick: int, event: ControlEvent) -> None:
        """Note an event that acts from the tick after `tick` on."""
        self.sink.put(line_of(tick, event))

    def measure(self, tick: int, measure: int, state: str) -> None:
        """Note the state hash at the first tick of a measure (measures from 1)."""
        self._put({"tick": tick, "measure": measure, "hash": state})

    def prepare(self, show: Show) -> None:
        """Get ready to take snapshots of this show: some milliseconds, better spent before it begins."""
        if self._keeping is not None:
            self._keeping.prepare(show)

    def keep(self, show: Show, tick: int, *, begins: bool) -> None:
        """Take a snapshot of each measure, some ticks after its line; `begins`: the measure began with this tick."""
        if self._keeping is not None:
            self._keeping.after(show, tick, begins=begins)

    def facts(self) -> dict[str, int]:
        """For the status: see `JournalSink.facts`."""
        failed = {} if self._keeping is None else {"snapshots_failed": self._keeping.failed}
        return self.sink.facts() | failed

    @property
    def problem(self) -> str:
        """What is wrong with it, for the operator; words change at most with every factor of two. Empty: nothing."""
        if trouble := trouble_of(self.facts()):
            return trouble
        if self._keeping is not None and self._keeping.problem:
            return f"journal: {self._keeping.problem}"
        return ""

    def close(self, tick: int, *, ended: bool = True) -> None:
        """Note the last tick if the show has `ended`, write what waits and close."""
        if ended:
            self._put({"tick": tick, "end": True})
        self.sink.close()

    def _put(self, line: dict[str, Any]) -> None:
        self.sink.put(_compact(line))


def trouble_of(facts: Mapping[str, int]) -> str:
    """What `JournalSink.facts` say of the disk, in words that change seldom; empty: nothing."""
    if dropped := facts.get("dropped", 0):
        if facts.get("missing", dropped):
            return f"journal: {_about(dropped)} lines could not be written: is the disk full?"
        return f"journal: {_about(dropped)} lines are missing in it; now it is written again"
    if facts.get("behind", 0) >= BEHIND:
        return f"journal: the disk is {_about(facts['behind'])} lines behind"
    return ""


def _about(count: int) -> str:
    """One, or a power of two and more."""
    return str(count) if count < 2 else f"{1 << (count.bit_length() - 1)} and more"


def line_of(tick: int, event: ControlEvent) -> str:
    """The line of an event that acts from the tick after `tick` on; what is as usual is left out."""
    if isinstance(event, IN_ROWS):
        return _compact({"tick": tick, "event": event_to_row(event)})
    usual = _usual(type(event).__name__)
    values = {key: value for key, value in event_to_json(event).items() if usual.get(key, MISSING) != value}
    return _compact({"tick": tick, "event": values})


@cache
def _usual(name: str) -> dict[str, Any]:
    return {field.name: field.default for field in fields(EVENT_TYPES[name]) if field.default is not MISSING}


def _compact(line: dict[str, Any]) -> str:
    return json.dumps(line, separators=(",", ":"))
