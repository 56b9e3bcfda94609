"""Disk: the journal's files, written beside the show and not by it, so that they are whole whatever ends an engine."""

import base64
import json
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final

from live.base.fault_isolation import run_once
from live.show.journal.journal_file import SNAPSHOTS, JournalFile, keep_aside
from live.show.journal.line_writer import Unwritten, Written

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
