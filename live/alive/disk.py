"""Disk: the journal's files, written beside the show and not by it, so that they are whole whatever ends an engine."""

import base64
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from live.show.journal_file import SNAPSHOTS, JournalFile, keep_aside


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
        self._refused = 0
        self._wanted = path is not None
        self._file: JournalFile | None = None
        self._notes: list[str] = []

    def put(self, line: str) -> None:
        """One line, without its end; never waits."""
        if self._path is not None and self._file is None:
            self._open(self._path)
        if self._file is None:
            self._refused += self._wanted
            return
        if '"snapshot":' in line[:64]:
            self._file.snapshot(Sealed(base64.b64decode(json.loads(line)["snapshot"])))
        else:
            self._file.put(line)

    def facts(self) -> dict[str, int]:
        """For the status: lines, bytes, what was dropped."""
        if self._file is None:
            return {"dropped": self._refused} if self._refused else {}
        return self._file.facts()

    def close(self) -> list[str]:
        """Write what waits; what there is to tell the person."""
        if self._file is not None:
            self._file.close()
            if dropped := self._file.facts()["dropped"]:
                self._notes.append(f"{dropped} lines of the journal could not be written: a replay leaves a gap")
        return self._notes

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
