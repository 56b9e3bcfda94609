"""Log: what another engine needs to go on with the show: the first line, the last snapshot and all lines since.

Disk: the journal's files, written beside the show and not by it, so that they are whole whatever ends an engine.
"""

import base64
import json
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Final

from live.base.fault_isolation import run_once
from live.show.journal.journal_writer import SNAPSHOTS, JournalFile, Unwritten, Written, keep_aside
from live.show.journal.skipped_events import LEFT_OUT, SINCE, without_the_last

CHANGES: Final = ("PatchChanged", "StepsAdded", "StepsChanged")
"""Events after which a snapshot can be read only by who has seen them."""
TICK: Final = '{"tick":'
FRONT: Final = 48
"""Characters within which the second key of a line begins."""
READ: Final = (*CHANGES, '"snapshot"', f'"{LEFT_OUT}"', '"end"')
"""Lines with these words are looked into."""


class Log:
    """Takes the lines of a running show's journal and keeps as few of them as will do.

    Without snapshots that is all of them (about 3 MB an hour), and so it is once patch or steps have changed: the last
    snapshot from before is kept then, and all that came after. Lines that only say how far the ticks are, are not kept:
    only the last one counts. Times of the show mean nothing to another process, so the clock's origin is kept, too.
    """

    def __init__(self) -> None:
        self.header: str = ""
        """The journal's first line; empty before the show has begun."""
        self.tick = 0
        """The last tick that was told."""
        self.measures = 0
        self.events = 0
        self._snapshot = ""
        self._changed = False
        self._lines: list[tuple[int, str]] = []

    def take(self, line: str) -> bool:
        """Take one line of the show; True if it belongs into a journal on disk. Lines that are no JSON are refused."""
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
        return self._take(value, tick, line)

    def note(self, line: str) -> None:
        """Take one line that this process has made itself, compact and in order, without reading it as JSON.

        Lines that only say how far the ticks are belong to `tick`.
        """
        if line.startswith('{"journal"'):
            self.header = self.header or line
            return
        end = line.find(",", len(TICK))
        if not line.startswith(TICK) or not line[len(TICK) : end].isdigit() or any(name in line for name in READ):
            self.take(line)
            return
        tick = int(line[len(TICK) : end])
        self.tick = max(self.tick, tick)
        event = line.find('"event"', 0, FRONT) >= 0
        self.events += event
        self.measures += not event and '"measure"' in line[:FRONT]
        self._lines.append((tick, line))

    def _take(self, value: dict[str, Any], tick: int, line: str) -> bool:
        if "snapshot" in value:
            if not self._changed:
                self._snapshot = line
                self._lines = [one for one in self._lines if one[0] > tick or (one[0] == tick and '"event"' in one[1])]
            return True
        self.tick = max(self.tick, tick)
        if isinstance(since := value.get(SINCE), int):  # who goes on from here dances anew what came since
            self._lines = [one for one in self._lines if one[0] <= since or '"measure"' not in one[1]]
            value = {key: each for key, each in value.items() if key != SINCE} | {"tick": since}
            place = sum(one[0] <= since for one in self._lines)
            self._lines.insert(place, (since, json.dumps(value, separators=(",", ":"))))
            return True
        if LEFT_OUT in value:  # who goes on from here leaves them out as well
            self._lines = without_the_last(self._lines, value[LEFT_OUT])
            return True
        if len(value) == 1:
            return False
        if "event" in value:
            self.events += 1
            event = value["event"]
            self._changed = self._changed or (isinstance(event, dict) and event.get("type") in CHANGES)
        self.measures += "measure" in value
        if not value.get("end"):
            self._lines.append((tick, line))
        return True

    def since(self) -> Iterator[str]:
        """All that a follower needs, in order; the last line says how far the ticks are."""
        if not self.header:
            return
        yield self.header
        if self._snapshot:
            yield self._snapshot
        yield from (line for _, line in self._lines)
        yield json.dumps({"tick": self.tick})


HELD: Final = 65536
"""Lines that wait while an engine still writes itself; more are dropped, and counted."""


@dataclass(frozen=True, slots=True)
class Sealed:
    """A snapshot as it came from the engine."""

    data: bytes

    def seal(self) -> bytes:
        """It is sealed already."""
        return self.data


class Disk:
    """Writes a journal; begun with its first line, so that a start that is refused leaves an old one."""

    def __init__(self, path: Path | None, say: Callable[[str], None] = lambda line: None) -> None:
        """`path`: where to; None: nowhere. `say`: tells the person at once what cannot wait for the end."""
        self._path, self._say = path, say
        self._place = path
        self._refused = 0
        self._wanted = path is not None
        self._file: JournalFile | None = None
        self._notes: list[str] = []
        self._due: Unwritten | None = None
        self._held: list[tuple[int, str]] = []
        self._kept = 0

    def go_on(self, unwritten: Unwritten, kept: int) -> None:
        """The journal is there, and is gone on with once `resume` is called: an engine may still write itself.

        `kept`: bytes of the file of snapshots that stay.
        """
        self._due, self._kept = unwritten, kept

    def resume(self) -> None:
        """Nobody else writes any more."""
        due, self._due = self._due, None
        if due is None or self._path is None:
            return
        path, self._path = self._path, None
        lines = [*due.lines, *((number, line) for number, line in self._held if not _is_snapshot(line))]
        self._file = JournalFile(
            path, path.with_name(path.name + SNAPSHOTS), unwritten=replace(due, lines=lines), kept=self._kept
        )
        for _, line in self._held:
            if _is_snapshot(line):
                self.put(line)
        self._held = []

    def put(self, line: str, number: int = 0) -> None:
        """One line, without its end; never waits. `number`: how `written` is to speak of it."""
        if self._file is not None and line.startswith('{"journal"'):
            self._begin_anew(self._file)
        if self._due is not None and self._path is not None:
            if len(self._held) < HELD:
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
            self._file.snapshot(Sealed(base64.b64decode(json.loads(line)["snapshot"])))
        else:
            self._file.put(line, number)

    @property
    def written(self) -> tuple[Written, int] | None:
        """How far the lines have come, and how many bytes of snapshots stay; None until that is known."""
        return None if self._file is None else self._file.written

    def facts(self) -> dict[str, int]:
        """For the status: lines, bytes, what was dropped."""
        if self._file is None:
            return {"dropped": self._refused} if self._refused else {}
        facts = self._file.facts()
        return facts | {"dropped": facts["dropped"] + self._refused}

    def close(self) -> list[str]:
        """Write what waits; what there is to tell the person."""
        self.resume()
        if self._file is not None:
            self._file.close()
            if dropped := self.facts()["dropped"]:
                self._notes.append(f"{dropped} lines of the journal could not be written: a replay leaves a gap")
        return self._notes

    def _begin_anew(self, file: JournalFile) -> None:
        """Another show begins, which this machine follows: the journal of the one before is kept beside it."""
        self._file, self._path = None, self._place
        ending = partial(run_once, "the end of the journal before", file.close)
        threading.Thread(target=ending, name="journal", daemon=True).start()  # it may wait for the disk

    def _open(self, path: Path) -> None:
        self._path = None
        try:
            kept = keep_aside(path)
            self._file = JournalFile(path, path.with_name(path.name + SNAPSHOTS))
        except OSError as error:
            self._say(f"the journal {path} cannot be written: {error.strerror}; the show goes on without it")
            return
        if kept is not None:
            self._notes.append(f"the journal that was there is now {kept}")


def _is_snapshot(line: str) -> bool:
    return '"snapshot":' in line[:64]
