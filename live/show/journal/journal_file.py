"""JournalFile: a journal on disk, lines and snapshots, each written by a thread of its own.

Snapshots lie beside the lines, one after another. The last few are there at every measure; of older ones every
KEEP_EVERY-th stays, so that a long night stays small and any measure is a few measures' replay away.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final, Protocol

from live.show.journal.clerk import Clerk
from live.show.journal.line_writer import LineWriter, Unwritten, Written
from live.show.journal.whole_writes import WholeWrites

KEEP_EVERY: Final = 8
"""Of so many snapshots one stays."""
WAITING: Final = 2
"""Snapshots that may wait for the disk; more are dropped, and counted."""
MARK: Final = b'{"snapshot":'
"""With this the first line of a snapshot begins."""
LONGEST_HEADER: Final = 4096
GAP: Final = "gap"
"""In a line of a journal: so many before it are missing."""
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


class SnapshotFile(Clerk[Sealable]):
    """Writes snapshots by a thread of its own; when the disk is slow or full, they are dropped and counted."""

    def __init__(self, path: Path, *, kept: int = 0) -> None:
        """Raises OSError if the file cannot be made; `kept`: of a file that is there, so many bytes stay."""
        self._file = WholeWrites(path, more=kept > 0)
        self._file.cut(min(kept, self._file.end))
        self.kept = self._file.end
        """Where what stays ends [bytes]."""
        self.written, self.bytes = 0, 0
        """Snapshots and bytes written, since the start."""
        super().__init__("snapshots", WAITING)

    def _write(self, item: Sealable) -> None:
        self._add(item.seal())

    def _add(self, sealed: bytes) -> None:
        if self._file.removed:
            self._file.again()
            self.kept = 0
        stays = self.written % KEEP_EVERY == 0
        if stays:
            self._file.cut(self.kept)
        self._file.add(sealed)
        self.written += 1
        self.bytes += len(sealed)
        if stays:
            self.kept = self._file.end

    def _finish(self) -> None:
        self._file.close()


def with_gap(line: str, missing: int) -> str:
    """A line of a journal (one JSON object) that says: before it so many are missing."""
    return f'{line[:-1]},"{GAP}":{missing}}}'


class JournalFile:
    """A `JournalSink` of two files."""

    def __init__(self, path: Path, snapshots: Path, *, unwritten: Unwritten | None = None, kept: int = 0) -> None:
        """Raises OSError if they cannot be made; `snapshots` is made with the first one.

        `unwritten`: both are there and are gone on with, of the snapshots' the first `kept` bytes; then nothing is
        raised.
        """
        self._lines = LineWriter(path, name="journal", mark=with_gap, unwritten=unwritten, aside=keep_aside)
        self._beside = snapshots
        self._kept = kept
        if unwritten is None:
            self._beside.unlink(missing_ok=True)
        self._snapshots: SnapshotFile | None = None
        self._refused = 0

    def put(self, line: str, number: int = 0) -> None:
        """Take one line, without its end; `number`: how `written` is to speak of it."""
        self._lines.line(line, number)

    @property
    def written(self) -> tuple[Written, int] | None:
        """How far the lines have come, and how many bytes of snapshots stay; None until that is known."""
        if self._lines.written is None:
            return None
        return self._lines.written, self._kept if self._snapshots is None else self._snapshots.kept

    def end(self) -> bool:
        """Have it write what waits and close; whether it has. To be called until it has; never waits."""
        ended = [file.end() for file in (self._lines, self._snapshots) if file is not None]
        return all(ended)

    def snapshot(self, taken: Sealable) -> None:
        """Take a snapshot."""
        if self._snapshots is None:
            try:
                self._snapshots = SnapshotFile(self._beside, kept=self._kept)
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
            "missing": lines.missing,
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
    from live.show.state.snapshot import SnapshotError, facts_of  # whoever only writes needs no array

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
