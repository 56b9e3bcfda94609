"""Recovery log: everything another engine needs to resume the show, and the journal files on disk."""

import base64
import json
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Final

from live.base.fault_isolation import run_once
from live.show.journal.journal_writer import SNAPSHOT_SUFFIX, JournalFile, move_aside
from live.show.journal.line_writer import UnfinishedFile, WriteProgress
from live.show.journal.skipped_events import SINCE_KEY, SKIPPED_KEY, drop_last_events

PATCH_EVENTS: Final = ("PatchChanged", "StepsAdded", "StepsChanged", "ExamplesChanged")
"""Events after which a snapshot can be read only by a process that has applied them."""
TICK: Final = '{"tick":'
KEY_WITHIN: Final = 48
"""The second key of a line begins within this many characters."""
PARSED_WORDS: Final = (*PATCH_EVENTS, '"snapshot"', f'"{SKIPPED_KEY}"', '"end"')
"""Lines that contain one of these are parsed."""


class RecoveryLog:
    """Keeps the journal lines of a running show that are needed to resume it, and no more.

    Without snapshots these are all lines (about 3 MB an hour). Once patch or steps have changed, the last snapshot from
    before the change and all later lines are kept. Of the lines that hold only a tick, the last one counts. The header
    holds the clock's origin, because show times mean nothing to another process.
    """

    def __init__(self) -> None:
        self.header: str = ""
        """The journal's first line; empty before the show has begun."""
        self.tick = 0
        """The last tick received."""
        self.measures = 0
        self.events = 0
        self._snapshot = ""
        self._changed = False
        self._lines: list[tuple[int, str]] = []

    def add_line(self, line: str) -> bool:
        """Add one line of the show; return whether it belongs into the journal on disk. Lines that are no JSON are
        refused."""
        try:
            value = json.loads(line)
        except ValueError:
            return False
        if not isinstance(value, dict):
            return False
        if "journal" in value:
            first = not self.header
            if first:
                self.header = line
            return first
        tick = value.get("tick")
        if not isinstance(tick, int):
            return False
        return self._add_value(value, tick, line)

    def add_own_line(self, line: str) -> None:
        """Add one line written by this process, compact and in order, without parsing it.

        A line that holds only a tick is not passed here: set `tick` instead.
        """
        if line.startswith('{"journal"'):
            self.header = self.header or line
            return
        end = line.find(",", len(TICK))
        if (
            not line.startswith(TICK)
            or not line[len(TICK) : end].isdigit()
            or any(name in line for name in PARSED_WORDS)
        ):
            self.add_line(line)
            return
        tick = int(line[len(TICK) : end])
        self.tick = max(self.tick, tick)
        event = line.find('"event"', 0, KEY_WITHIN) >= 0
        self.events += event
        self.measures += not event and '"measure"' in line[:KEY_WITHIN]
        self._lines.append((tick, line))

    def _add_value(self, value: dict[str, Any], tick: int, line: str) -> bool:
        if "snapshot" in value:
            if not self._changed:
                self._snapshot = line
                self._lines = [one for one in self._lines if one[0] > tick or (one[0] == tick and '"event"' in one[1])]
            return True
        self.tick = max(self.tick, tick)
        if isinstance(since := value.get(SINCE_KEY), int):  # a show resumed from here reruns everything since
            self._lines = [one for one in self._lines if one[0] <= since or '"measure"' not in one[1]]
            value = {key: each for key, each in value.items() if key != SINCE_KEY} | {"tick": since}
            place = sum(one[0] <= since for one in self._lines)
            self._lines.insert(place, (since, json.dumps(value, separators=(",", ":"))))
            return True
        if SKIPPED_KEY in value:  # a show resumed from here skips them, too
            self._lines = drop_last_events(self._lines, value[SKIPPED_KEY])
            return True
        if len(value) == 1:
            return False
        if "event" in value:
            self.events += 1
            event = value["event"]
            self._changed = self._changed or (isinstance(event, dict) and event.get("type") in PATCH_EVENTS)
        self.measures += "measure" in value
        if not value.get("end"):
            self._lines.append((tick, line))
        return True

    def replay_lines(self) -> Iterator[str]:
        """Yield all lines that a follower needs, in order; the last one holds the current tick."""
        if not self.header:
            return
        yield self.header
        if self._snapshot:
            yield self._snapshot
        yield from (line for _, line in self._lines)
        yield json.dumps({"tick": self.tick})


MAX_HELD_LINES: Final = 65536
"""Most lines that wait while an engine still writes the journal itself; more are dropped and counted."""


@dataclass(frozen=True, slots=True)
class SealedSnapshot:
    """A snapshot received from the engine."""

    data: bytes

    def seal(self) -> bytes:
        """Return the data, which is sealed already."""
        return self.data


class JournalDisk:
    """Writes the journal. Its file is opened with the first line, so a start that fails keeps an old journal."""

    def __init__(self, path: Path | None, say: Callable[[str], None] = lambda line: None) -> None:
        """`path`: the journal; None: none. `say`: prints what the person has to know at once."""
        self._path, self._say = path, say
        self._first_path = path
        self._refused = 0
        self._wanted = path is not None
        self._file: JournalFile | None = None
        self._notes: list[str] = []
        self._to_resume: UnfinishedFile | None = None
        self._held: list[tuple[int, str]] = []
        self._kept = 0

    def prepare_resume(self, unwritten: UnfinishedFile, kept: int) -> None:
        """Prepare to continue an existing journal once `resume` is called; until then an engine may still write it.

        `kept`: bytes of the snapshot file that stay.
        """
        self._to_resume, self._kept = unwritten, kept

    def resume(self) -> None:
        """Start writing: no other process writes the journal any more."""
        due, self._to_resume = self._to_resume, None
        if due is None or self._path is None:
            return
        path, self._path = self._path, None
        lines = [*due.lines, *((number, line) for number, line in self._held if not _is_snapshot(line))]
        self._file = JournalFile(
            path, path.with_name(path.name + SNAPSHOT_SUFFIX), unwritten=replace(due, lines=lines), kept=self._kept
        )
        for _, line in self._held:
            if _is_snapshot(line):
                self.write(line)
        self._held = []

    def write(self, line: str, number: int = 0) -> None:
        """Write one line, without its line end; never waits. `number`: identifies the line in `written`."""
        if self._file is not None and line.startswith('{"journal"'):
            self._begin_next(self._file)
        if self._to_resume is not None and self._path is not None:
            if len(self._held) < MAX_HELD_LINES:
                self._held.append((number, line))
            else:
                self._refused += 1
            return
        if self._path is not None and self._file is None:
            self._open(self._path)
        if self._file is None:
            self._refused += self._wanted
            return
        if _is_snapshot(line):
            self._file.snapshot(SealedSnapshot(base64.b64decode(json.loads(line)["snapshot"])))
        else:
            self._file.put(line, number)

    @property
    def written(self) -> tuple[WriteProgress, int] | None:
        """The last line written and the bytes of snapshots that stay; None until that is known."""
        return None if self._file is None else self._file.written

    def facts(self) -> dict[str, int]:
        """Return figures for the status: lines, bytes, dropped lines."""
        if self._file is None:
            return {"dropped": self._refused} if self._refused else {}
        facts = self._file.facts()
        return facts | {"dropped": facts["dropped"] + self._refused}

    def close(self) -> list[str]:
        """Write everything pending; return notes for the person."""
        self.resume()
        if self._file is not None:
            self._file.close()
            if dropped := self.facts()["dropped"]:
                self._notes.append(f"{dropped} lines of the journal could not be written: a replay leaves a gap")
        return self._notes

    def _begin_next(self, file: JournalFile) -> None:
        """Start the journal of another show, which this machine follows; the previous journal is kept under another
        name."""
        self._file, self._path = None, self._first_path
        ending = partial(run_once, "the end of the journal before", file.close)
        threading.Thread(target=ending, name="journal", daemon=True).start()  # it may wait for the disk

    def _open(self, path: Path) -> None:
        self._path = None
        try:
            kept = move_aside(path)
            self._file = JournalFile(path, path.with_name(path.name + SNAPSHOT_SUFFIX))
        except OSError as error:
            self._say(f"the journal {path} cannot be written: {error.strerror}; the show goes on without it")
            return
        if kept is not None:
            self._notes.append(f"the journal that was there is now {kept}")


def _is_snapshot(line: str) -> bool:
    return '"snapshot":' in line[:64]
