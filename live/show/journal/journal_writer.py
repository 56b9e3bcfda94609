"""JournalFile: a journal on disk, lines and snapshots, each written by a thread of its own.

Snapshots lie beside the lines, one after another. The last few are there at every measure; of older ones every
KEEP_EVERY-th stays, so that a long night stays small and any measure is a few measures' replay away.

Clerk: writes by a thread of its own what the show hands over, so that the show never waits for the disk.

WholeWrites: a file to which pieces are added that are there whole or not at all, whatever the disk does.

LineWriter: lines of text into a file by a thread of its own, so that the show never waits for the disk.
"""

import contextlib
import os
import queue
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final, Generic, Protocol, TypeVar

from live.base.fault_isolation import FAULTS

Item = TypeVar("Item")


class Clerk(Generic[Item]):
    """Thread: `put` and `close` from the show's thread; `_write` and `_finish`, which a file defines, run in its own.

    When the disk is slow or full, things are dropped and counted.
    """

    def __init__(self, name: str, capacity: int) -> None:
        """Begin; `name` is the thread's, and `capacity` things may wait for the disk."""
        self._waiting: queue.Queue[Item | None] = queue.Queue(capacity)
        self._ends = False
        self.dropped = 0
        """Things lost because the disk did not keep up or refused them."""
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def put(self, item: Item) -> bool:
        """Hand over one thing; never waits. False if it is lost, for too many wait."""
        try:
            self._waiting.put_nowait(item)
        except queue.Full:
            self.dropped += 1
            return False
        return True

    @property
    def behind(self) -> int:
        """Things that wait for the disk."""
        return self._waiting.qsize()

    def close(self) -> None:
        """Write what waits and close; gives up on a stuck disk after two seconds."""
        try:
            self._waiting.put(None, timeout=1.0)
        except queue.Full:
            return
        self._thread.join(2.0)

    def end(self) -> bool:
        """Have it write what waits and close, and do not wait for that; whether it has. To be called until it has."""
        if not self._ends:
            with contextlib.suppress(queue.Full):
                self._waiting.put_nowait(None)
                self._ends = True
        return not self._thread.is_alive()

    def _run(self) -> None:
        try:
            self._begin()
        except OSError:
            self.dropped += 1
        while (item := self._waiting.get()) is not None:
            try:
                self._write(item)
            except OSError:
                self.dropped += 1
            except Exception as error:  # one thing that cannot be written must not be the last one
                self.dropped += 1
                FAULTS.note(f"the writer of the {self._thread.name}", error)
        try:
            self._finish()
        except OSError:
            self.dropped += 1

    def _begin(self) -> None:
        """What is to be done first, by the same thread."""

    def _write(self, item: Item) -> None:
        raise NotImplementedError

    def _finish(self) -> None:
        raise NotImplementedError


if sys.platform != "win32":
    import fcntl

LOOK: Final = 0.02
"""Seconds between two attempts to be the only one who writes."""
MOST: Final = 1 << 26
"""Bytes that are read back at most."""


class WholeWrites:
    """An open file without a buffer: what a full disk has taken of a piece is taken back. Thread: one at a time."""

    def __init__(self, path: Path, *, more: bool = False) -> None:
        """Make the file, or go on behind what it holds (`more`); raises OSError if that cannot be."""
        self._path = path
        self._file = path.open("ab" if more else "wb", buffering=0)
        self.end = self._file.seek(0, os.SEEK_END)
        """Bytes in it."""

    def add(self, data: bytes) -> None:
        """Add a piece at the end; OSError if it has no room, and then nothing of it is there."""
        done = 0
        try:
            while done < len(data):
                done += self._file.write(data[done:])
        except OSError:
            with contextlib.suppress(OSError):
                self.cut(self.end)
            raise
        self.end += len(data)

    def lines_from(self, begin: int) -> list[bytes]:
        """The whole lines behind so many bytes, without their ends; a last one that is cut off is taken back.

        Where the file is shorter than that, somebody else has written it: then those of its last MOST bytes.
        """
        begin = max(begin if begin <= self.end else 0, self.end - MOST)
        with self._path.open("rb") as file:
            file.seek(begin)
            *whole, torn = file.read(self.end - begin).split(b"\n")
        if torn:
            self.cut(self.end - len(torn))
        return whole

    def claim(self, within: float = 0.0) -> None:
        """Be the only process that writes it, until it is closed; BlockingIOError if another one still is after so
        many seconds. Where the file system knows no locks (flock(2)) nothing is claimed."""
        if sys.platform == "win32":
            return
        deadline = time.monotonic() + within
        while True:
            try:
                fcntl.flock(self._file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
                return
            except BlockingIOError:
                if time.monotonic() >= deadline:
                    raise
            except OSError:
                return
            time.sleep(LOOK)

    def cut(self, end: int) -> None:
        """Forget what lies behind so many bytes."""
        self._file.truncate(end)
        self.end = self._file.seek(end)

    @property
    def removed(self) -> bool:
        """Whether somebody has removed the file, so that what is added is lost."""
        return os.fstat(self._file.fileno()).st_nlink == 0

    def again(self) -> None:
        """Make a removed file again, empty, with its folder; OSError if that cannot be, or another one is there now."""
        self._path.parent.mkdir(parents=True, exist_ok=True)
        file = self._path.open("xb", buffering=0)
        self._file.close()
        self._file, self.end = file, 0

    def close(self) -> None:
        """Close it."""
        self._file.close()


CAPACITY: Final = 65536
"""Lines that may wait for the disk."""
CLAIM_WITHIN: Final = 5.0
"""Seconds in which another process that writes the file ends, or is ended; two never write it at once."""


@dataclass(frozen=True, slots=True)
class Written:
    """How far lines have come to the disk."""

    number: int = 0
    """Of the last line that is done with: it is in the file, or it is counted as missing."""
    end: int = 0
    """Bytes in the file then."""
    missing: int = 0
    """Lines lost since the last one that is in it."""


@dataclass(frozen=True, slots=True)
class Unwritten:
    """A file of lines that another process wrote until it ended, and lines of which it may have written some."""

    first: str
    """The file's first line, for who has to begin it anew."""
    written: Written
    """What is known to be in it."""
    lines: Sequence[tuple[int, str]]
    """All lines since, in order, each with its number."""


class LineWriter(Clerk[tuple[str, int, int]]):
    """Takes lines from the show's thread; when the disk is slow or full, lines are dropped and counted.

    Once there is room again it goes on, with the next line whole: each is there as a line or not at all. A file that
    was removed is made again. Thread: the file is touched only by the writer's own, after the start.
    """

    def __init__(
        self, path: Path, *, name: str, more: bool = False, mark: Callable[[str, int], str] | None = None,
        unwritten: Unwritten | None = None, aside: Callable[[Path], object] = lambda path: None,
    ) -> None:  # fmt: skip
        """Raises OSError if the file cannot be made; `name` is the thread's; `more`: behind what the file holds.

        `mark` writes into a line how many before it are missing; then the first line, without which the others mean
        nothing, is never left out. `unwritten`: the file is gone on with where another process ended; it is opened by
        the thread, and nothing is raised. `aside`: what is done with a file that begins otherwise.
        """
        self._path = path
        self._due, self._aside = unwritten, aside
        self._file = None if unwritten is not None else WholeWrites(path, more=more)
        if self._file is not None and mark is not None:
            with contextlib.suppress(BlockingIOError):
                self._file.claim()
        self._mark = mark
        self._missed = 0  # that found too many waiting, since the last that did not
        self._first = b"" if unwritten is None else unwritten.first.encode() + b"\n"
        self._owed: bytes = b""  # to be written before anything else
        self._there = 0
        self.missing = 0
        """Lines lost since the last one that was written."""
        self.lines, self.bytes = 0, 0
        """Lines taken, and bytes written, since the start."""
        self.written: Written | None = None
        """How far they have come; None until the file is open."""
        super().__init__(name, CAPACITY)

    def line(self, line: str, number: int = 0) -> None:
        """Hand over one line, without its end; never waits. `number`: how `written` is to speak of it."""
        if self.put((line, self._missed, number)):
            self._missed = 0
            self.lines += 1
        else:
            self._missed += 1

    def _begin(self) -> None:
        """Cut what is torn, and write what is missing."""
        due = self._due
        if due is None:
            return
        if not begins_with(self._path, self._first):
            self._aside(self._path)
        file = WholeWrites(self._path, more=True)
        try:
            file.claim(CLAIM_WITHIN)
        except OSError:
            file.close()
            raise
        there = file.lines_from(due.written.end)
        self._file, self._due = file, None
        self.missing += due.written.missing
        if file.end == 0 and not (due.lines and due.lines[0][1] == due.first):
            self._owed = self._first
            self.missing += 1  # or more: nobody knows what the file held
        for number, line in not_there(due.lines, there):
            try:
                self._write((line, 0, number))
            except OSError:
                self.dropped += 1
        last = max((number for number, _ in due.lines), default=due.written.number)
        self.written = Written(last, file.end, self.missing)

    def _write(self, item: tuple[str, int, int]) -> None:
        line, missed, number = item
        self.missing += missed
        try:
            self._begin()
            self._look_after_the_file()
            self._settle()
            text = self._mark(line, self.missing) if self._mark is not None and self.missing else line
            self._add(text.encode() + b"\n")
        except OSError:
            if self._mark is not None and not self._first:
                self._first = self._owed = line.encode() + b"\n"
            else:
                self.missing += 1
            raise
        else:
            self._first = self._first or line.encode() + b"\n"
            self.missing = 0
        finally:
            if self._file is not None and number:
                self.written = Written(number, self._file.end, self.missing)

    def _look_after_the_file(self) -> None:
        assert self._file is not None
        if self._file.removed:
            self._file.again()
            self.missing, self.dropped, self._there = self.missing + self._there, self.dropped + self._there, 0
            self._owed = self._first if self._mark is not None else b""

    def _settle(self) -> None:
        if self._owed:
            self._add(self._owed)
            self._owed = b""

    def _add(self, data: bytes) -> None:
        assert self._file is not None
        self._file.add(data)
        self.bytes += len(data)
        self._there += data is not self._owed

    def _finish(self) -> None:
        if self._file is not None:
            self._file.close()


def not_there(lines: Sequence[tuple[int, str]], there: Sequence[bytes]) -> Sequence[tuple[int, str]]:
    """The last of `lines`, behind all that are `there` (n whole lines of a file, in the same order).

    A line before one that is there, and not there itself, was lost by whoever wrote: it is not written out of order.
    A line to which it was added what is missing before it counts as the same.
    """
    texts = [line.encode() for _, line in lines]
    places: dict[bytes, list[int]] = {}
    for place in range(len(texts) - 1, -1, -1):
        places.setdefault(texts[place], []).append(place)  # the first is the last of the list
    begin = 0
    for row in there:
        found = places.get(row) or places.get(without_mark(row)) or []
        while found and found[-1] < begin:
            found.pop()
        if found:
            begin = found.pop() + 1
    return lines[begin:]


def begins_with(path: Path, first: bytes) -> bool:
    """Whether a file, if it is there and holds anything, begins with these bytes."""
    try:
        with path.open("rb") as file:
            head = file.read(len(first))
    except FileNotFoundError:
        return True
    return not head or head == first


def without_mark(row: bytes) -> bytes:
    """A line without what a `mark` like `with_gap` added at its end."""
    head, comma, tail = row.rpartition(b',"gap":')
    return head + b"}" if comma and tail[:-1].isdigit() else row


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
