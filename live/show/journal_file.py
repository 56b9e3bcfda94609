"""JournalFile: a journal on disk, lines and snapshots, each written by a thread of its own.

Snapshots lie beside the lines, one after another. The last few are there at every measure; of older ones every
KEEP_EVERY-th stays, so that a long night stays small and any measure is a few measures' replay away.
"""

import queue
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final, Protocol

from live.show.line_writer import LineWriter

KEEP_EVERY: Final = 8
"""Of so many snapshots one stays."""
WAITING: Final = 2
"""Snapshots that may wait for the disk; more are dropped, and counted."""
MARK: Final = b'{"snapshot":'
"""With this the first line of a snapshot begins."""
LONGEST_HEADER: Final = 4096
SNAPSHOTS: Final = ".snap"
"""What is added to a journal's name for the file of its snapshots."""


class Sealable(Protocol):
    """A snapshot (`Taken`, or one that another process has sealed)."""

    def seal(self) -> bytes:
        """As it is written. Thread: any."""
        ...


def keep_aside(path: Path) -> Path | None:
    """Move a file that is there, and its snapshots, to the first free of path.1, path.2 …; None if there is none."""
    if not path.is_file() or path.stat().st_size == 0:
        return None
    number = 1
    while (kept := path.with_name(f"{path.name}.{number}")).exists():
        number += 1
    path.replace(kept)
    beside = path.with_name(path.name + SNAPSHOTS)
    if beside.is_file():
        beside.replace(kept.with_name(kept.name + SNAPSHOTS))
    return kept


class SnapshotFile:
    """Writes snapshots by a thread of its own; when the disk is slow or full, they are dropped and counted."""

    def __init__(self, path: Path) -> None:
        """Raises OSError if the file cannot be made."""
        self._file = path.open("wb")
        self._waiting: queue.Queue[Sealable | None] = queue.Queue(WAITING)
        self._kept = 0  # where what stays ends
        self.written, self.dropped, self.bytes = 0, 0, 0
        """Snapshots and bytes written, snapshots lost, since the start."""
        self._thread = threading.Thread(target=self._write, name="snapshots", daemon=True)
        self._thread.start()

    def put(self, taken: Sealable) -> None:
        """Hand over one snapshot; never waits. Thread: the show's."""
        try:
            self._waiting.put_nowait(taken)
        except queue.Full:
            self.dropped += 1

    def close(self) -> None:
        """Write what waits and close; gives up on a stuck disk after two seconds."""
        try:
            self._waiting.put(None, timeout=1.0)
        except queue.Full:
            return
        self._thread.join(2.0)

    def _write(self) -> None:
        while (taken := self._waiting.get()) is not None:
            try:
                self._add(taken.seal())
            except OSError:
                self.dropped += 1
        try:
            self._file.close()
        except OSError:
            self.dropped += 1

    def _add(self, sealed: bytes) -> None:
        stays = self.written % KEEP_EVERY == 0
        if stays:
            self._file.seek(self._kept)
            self._file.truncate()
        self._file.write(sealed)
        self._file.flush()
        self.written += 1
        self.bytes += len(sealed)
        if stays:
            self._kept = self._file.tell()


class JournalFile:
    """A `JournalSink` of two files."""

    def __init__(self, path: Path, snapshots: Path) -> None:
        """Raises OSError if they cannot be made; `snapshots` is made with the first one."""
        self._lines = LineWriter(path, name="journal")
        self._beside = snapshots
        self._beside.unlink(missing_ok=True)
        self._snapshots: SnapshotFile | None = None
        self._refused = 0

    def put(self, line: str) -> None:
        """Take one line, without its end."""
        self._lines.put(line)

    def snapshot(self, taken: Sealable) -> None:
        """Take a snapshot."""
        if self._snapshots is None:
            try:
                self._snapshots = SnapshotFile(self._beside)
            except OSError:
                self._refused += 1
                return
        self._snapshots.put(taken)

    def facts(self) -> dict[str, int]:
        """Figures of both files."""
        lines, other = self._lines, self._snapshots
        return {
            "lines": lines.lines,
            "dropped": lines.dropped,
            "bytes": lines.bytes,
            "behind": lines.behind,
            "snapshots": 0 if other is None else other.written,
            "snapshots_dropped": self._refused + (0 if other is None else other.dropped),
            "snapshot_bytes": 0 if other is None else other.bytes,
        }

    def close(self) -> None:
        """Write what waits and close."""
        self._lines.close()
        if self._snapshots is not None:
            self._snapshots.close()


def read_snapshots(path: Path, problems: list[str]) -> Iterator[bytes]:
    """The snapshots of a file, one after another; what is damaged is told in `problems` and left out."""
    from live.show.snapshot import SnapshotError, facts_of  # whoever only writes needs no array

    try:
        file = path.open("rb")
    except FileNotFoundError:
        return
    except OSError as error:
        problems.append(f"cannot read the snapshots {path}: {error.strerror}")
        return
    with file:
        number, begin = 0, _next_mark(file, 0)
        while begin is not None:
            number += 1
            end = _next_mark(file, begin + 1)
            file.seek(begin)
            data = file.read() if end is None else file.read(end - begin)
            try:
                facts_of(data)
                yield data
            except SnapshotError as error:
                problems.append(f"{path}, snapshot {number}: {error}")
            begin = end


def _next_mark(file: BinaryIO, begin: int) -> int | None:
    """Where from `begin` on the next snapshot begins."""
    file.seek(begin)
    kept, place = b"", begin
    while block := file.read(1 << 20):
        found = (kept + block).find(MARK)
        if found >= 0:
            return place - len(kept) + found
        place += len(block)
        kept = (kept + block)[-len(MARK) :]
    return None
