"""Writer for journals on disk: lines and snapshots, each written by a thread of its own.

Snapshots go to a second file. The last few measures all have one; of older ones every KEEP_EVERY-th is kept, which
limits the file size and keeps every measure a short replay away from a snapshot.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final, Protocol

from live.show.journal.line_writer import (
    AtomicAppendFile,
    LineWriter,
    UnfinishedFile,
    WriteProgress,
    WriterThread,
    with_gap,
)

KEEP_EVERY: Final = 8
"""One in this many snapshots is kept."""
MAX_WAITING_SNAPSHOTS: Final = 2
"""Maximum number of snapshots that wait for the disk; more are dropped and counted."""
SNAPSHOT_MARK: Final = b'{"snapshot":'
"""Start of each snapshot's first line."""
SNAPSHOT_SUFFIX: Final = ".snap"
"""Suffix of the snapshot file, appended to the journal's name."""


class Sealable(Protocol):
    """A snapshot to be written: one captured in this process, or sealed by another."""

    def seal(self) -> bytes:
        """Return the bytes of the snapshot. Thread: any."""
        ...


def move_aside(path: Path) -> Path | None:
    """Move an existing file and its snapshots to the first free of path.1, path.2 …; None if there is no file."""
    if not path.is_file() or path.stat().st_size == 0:
        return None
    number = 1
    while (kept := path.with_name(f"{path.name}.{number}")).exists():
        number += 1
    path.replace(kept)
    beside = path.with_name(path.name + SNAPSHOT_SUFFIX)
    if beside.is_file():
        beside.replace(kept.with_name(kept.name + SNAPSHOT_SUFFIX))
    return kept


class SnapshotFile(WriterThread[Sealable]):
    """Writer for snapshots; they are dropped and counted if the disk is slow or full."""

    def __init__(self, path: Path, *, kept: int = 0) -> None:
        """Raises OSError if the file cannot be created; `kept`: bytes of an existing file to keep."""
        self._file = AtomicAppendFile(path, append=kept > 0)
        self._file.truncate(min(kept, self._file.end))
        self.kept = self._file.end
        """Size of the part that is kept permanently [bytes]."""
        self.written, self.bytes = 0, 0
        """Snapshots and bytes written, since the start."""
        super().__init__("snapshots", MAX_WAITING_SNAPSHOTS)

    def _write(self, item: Sealable) -> None:
        self._add(item.seal())

    def _add(self, sealed: bytes) -> None:
        if self._file.removed:
            self._file.recreate()
            self.kept = 0
        stays = self.written % KEEP_EVERY == 0
        if stays:
            self._file.truncate(self.kept)
        self._file.append(sealed)
        self.written += 1
        self.bytes += len(sealed)
        if stays:
            self.kept = self._file.end

    def _finish(self) -> None:
        self._file.close()


class JournalFile:
    """A `JournalSink` with two files, for lines and for snapshots."""

    def __init__(self, path: Path, snapshots: Path, *, unwritten: UnfinishedFile | None = None, kept: int = 0) -> None:
        """Raises OSError if a file cannot be created; `snapshots` is created with the first snapshot.

        `unwritten`: continue existing files, with the first `kept` bytes of the snapshots; then nothing is raised.
        """
        self._lines = LineWriter(path, name="journal", mark=with_gap, unwritten=unwritten, aside=move_aside)
        self._snapshot_path = snapshots
        self._kept = kept
        if unwritten is None:
            self._snapshot_path.unlink(missing_ok=True)
        self._snapshots: SnapshotFile | None = None
        self._refused = 0

    def put(self, line: str, number: int = 0) -> None:
        """Accept one line, without its line break; `number`: its number in `written`."""
        self._lines.line(line, number)

    @property
    def written(self) -> tuple[WriteProgress, int] | None:
        """Progress of the lines, and permanently kept bytes of the snapshots; None until it is known."""
        if self._lines.written is None:
            return None
        return self._lines.written, self._kept if self._snapshots is None else self._snapshots.kept

    def request_close(self) -> bool:
        """Start to write everything and close, without blocking. Returns whether it is done; call it until then."""
        ended = [file.request_close() for file in (self._lines, self._snapshots) if file is not None]
        return all(ended)

    def snapshot(self, taken: Sealable) -> None:
        """Accept a snapshot."""
        if self._snapshots is None:
            try:
                self._snapshots = SnapshotFile(self._snapshot_path, kept=self._kept)
            except OSError:
                self._refused += 1
                return
        self._snapshots.put(taken)

    def facts(self) -> dict[str, int]:
        """Return the figures of both files."""
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
        """Write everything and close."""
        self._lines.close()
        if self._snapshots is not None:
            self._snapshots.close()


def read_snapshots(path: Path, problems: list[str]) -> Iterator[bytes]:
    """Yield the snapshots of a file; damaged ones are skipped and reported in `problems`."""
    from live.show.state.snapshot import (  # imports numpy, which a writer process does not need
        SnapshotError,
        snapshot_header,
    )

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
                snapshot_header(data)
                yield data
            except SnapshotError as error:
                problems.append(f"{path}, snapshot {number}: {error}")
            begin = end


def _next_mark(file: BinaryIO, begin: int) -> int | None:
    """Return the position of the next snapshot from `begin` on; None if there is none."""
    file.seek(begin)
    kept, place = b"", begin
    while block := file.read(1 << 20):
        found = (kept + block).find(SNAPSHOT_MARK)
        if found >= 0:
            return place - len(kept) + found
        place += len(block)
        kept = (kept + block)[-len(SNAPSHOT_MARK) :]
    return None
