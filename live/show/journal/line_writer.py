"""Writer for lines on disk, in a thread of its own: it never blocks its callers, and continues an unfinished file."""

import contextlib
import os
import queue
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Generic, TypeVar

from live.base.fault_isolation import FAULTS
from live.base.system.file_lock import lock_file

Item = TypeVar("Item")


class WriterThread(Generic[Item]):
    """Base of file writers with a thread of their own; items are dropped and counted if the disk is slow or full.

    Thread: `put` and `close` from the show's thread; `_begin`, `_write` and `_finish`, which subclasses define, run in
    the writer's.
    """

    def __init__(self, name: str, capacity: int) -> None:
        """Start the thread. `name`: of the thread; `capacity`: maximum number of waiting items."""
        self._waiting: queue.Queue[Item | None] = queue.Queue(capacity)
        self._closing = False
        self.dropped = 0
        """Items lost because the disk was too slow or refused them."""
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def put(self, item: Item) -> bool:
        """Queue one item without blocking. False if it is lost because the queue is full."""
        try:
            self._waiting.put_nowait(item)
        except queue.Full:
            self.dropped += 1
            return False
        return True

    @property
    def behind(self) -> int:
        """Number of items that wait for the disk."""
        return self._waiting.qsize()

    def close(self) -> None:
        """Write all waiting items and close; gives up on a stuck disk after a few seconds."""
        try:
            self._waiting.put(None, timeout=1.0)
        except queue.Full:
            return
        self._thread.join(2.0)

    def request_close(self) -> bool:
        """Start to write all waiting items and close, without blocking. Returns whether it is done; call it until
        then."""
        if not self._closing:
            with contextlib.suppress(queue.Full):
                self._waiting.put_nowait(None)
                self._closing = True
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
            except Exception as error:  # one bad item must not end the thread
                self.dropped += 1
                FAULTS.record(f"the writer of the {self._thread.name}", error)
        try:
            self._finish()
        except OSError:
            self.dropped += 1

    def _begin(self) -> None:
        """Work before the first item, in the writer's thread."""

    def _write(self, item: Item) -> None:
        raise NotImplementedError

    def _finish(self) -> None:
        raise NotImplementedError


MAX_READ_BACK: Final = 1 << 26
"""Maximum number of bytes that are read back."""


class AtomicAppendFile:
    """An unbuffered file with atomic appends: a partial write is undone. Thread: one at a time."""

    def __init__(self, path: Path, *, append: bool = False) -> None:
        """Create the file, or append to it (`append`); raises OSError on failure."""
        self._path = path
        self._file = path.open("ab" if append else "wb", buffering=0)
        self.end = self._file.seek(0, os.SEEK_END)
        """Size of the file [bytes]."""

    def append(self, data: bytes) -> None:
        """Append data; on OSError nothing of it remains in the file."""
        done = 0
        try:
            while done < len(data):
                done += self._file.write(data[done:])
        except OSError:
            with contextlib.suppress(OSError):
                self.truncate(self.end)
            raise
        self.end += len(data)

    def lines_from(self, begin: int) -> list[bytes]:
        """Return the complete lines after the first `begin` bytes, without line breaks; a truncated last line is
        removed.

        If the file is shorter than `begin`, another process has rewritten it: then its last MOST bytes are read.
        """
        begin = max(begin if begin <= self.end else 0, self.end - MAX_READ_BACK)
        with self._path.open("rb") as file:
            file.seek(begin)
            *whole, torn = file.read(self.end - begin).split(b"\n")
        if torn:
            self.truncate(self.end - len(torn))
        return whole

    def lock(self, within: float = 0.0) -> None:
        """Lock the file against other writers until it is closed; BlockingIOError if another process still holds the
        lock after `within` seconds. If the system refuses a lock the file has none: a journal is still written."""
        try:
            lock_file(self._file, within=within)
        except BlockingIOError:
            raise
        except OSError:
            return

    def truncate(self, end: int) -> None:
        """Truncate the file to `end` bytes."""
        self._file.truncate(end)
        self.end = self._file.seek(end)

    @property
    def removed(self) -> bool:
        """Whether the file was deleted, so that appended data would be lost."""
        return os.fstat(self._file.fileno()).st_nlink == 0

    def recreate(self) -> None:
        """Create a deleted file again, empty, with its folder; OSError on failure, or if there is another one now."""
        self._path.parent.mkdir(parents=True, exist_ok=True)
        file = self._path.open("xb", buffering=0)
        self._file.close()
        self._file, self.end = file, 0

    def close(self) -> None:
        """Close it."""
        self._file.close()


MAX_WAITING_LINES: Final = 65536
"""Maximum number of lines that wait for the disk."""
LOCK_TIMEOUT: Final = 5.0
"""Time limit for getting the lock [s]; a previous writer process ends, or is killed, within it."""


@dataclass(frozen=True, slots=True)
class WriteProgress:
    """Progress of a line writer."""

    number: int = 0
    """Number of the last line handled: it is in the file, or counted as missing."""
    end: int = 0
    """Size of the file then [bytes]."""
    missing: int = 0
    """Lines lost since the last one written."""


@dataclass(frozen=True, slots=True)
class UnfinishedFile:
    """State of a file whose writer process has ended, with lines that may or may not be in it."""

    first: str
    """The file's first line, in case the file must be created again."""
    written: WriteProgress
    """Last known progress."""
    lines: Sequence[tuple[int, str]]
    """All lines since then, in order, each with its number."""


class LineWriter(WriterThread[tuple[str, int, int]]):
    """Writer for lines of text; lines are dropped and counted if the disk is slow or full.

    Each line is written completely or not at all, and writing resumes once there is room. A deleted file is created
    again. Thread: after the start only the writer's thread accesses the file.
    """

    def __init__(
        self, path: Path, *, name: str, append: bool = False, mark: Callable[[str, int], str] | None = None,
        unwritten: UnfinishedFile | None = None, aside: Callable[[Path], object] = lambda path: None,
    ) -> None:  # fmt: skip
        """Raises OSError if the file cannot be created. `name`: of the thread; `append`: append to the file.

        `mark` adds the number of missing lines to the next line; with it the first line (a header) is never dropped.
        `unwritten`: continue the file of a process that has ended; then the thread opens the file and nothing is
        raised. `aside`: called with the path if that file has another first line.
        """
        self._path = path
        self._due, self._aside = unwritten, aside
        self._file = None if unwritten is not None else AtomicAppendFile(path, append=append)
        if self._file is not None and mark is not None:
            with contextlib.suppress(BlockingIOError):
                self._file.lock()
        self._mark = mark
        self._missed = 0  # lines dropped by a full queue since the last one queued
        self._first = b"" if unwritten is None else unwritten.first.encode() + b"\n"
        self._owed: bytes = b""  # must be written before anything else
        self._lines_in_file = 0
        self.missing = 0
        """Lines lost since the last one written."""
        self.lines, self.bytes = 0, 0
        """Lines queued, and bytes written, since the start."""
        self.written: WriteProgress | None = None
        """Progress; None until the file is open."""
        super().__init__(name, MAX_WAITING_LINES)

    def line(self, line: str, number: int = 0) -> None:
        """Queue one line, without its line break; never blocks. `number`: its number in `written`."""
        if self.put((line, self._missed, number)):
            self._missed = 0
            self.lines += 1
        else:
            self._missed += 1

    def _begin(self) -> None:
        """Resume the file of another process: remove a truncated line and write the missing ones."""
        due = self._due
        if due is None:
            return
        if not begins_with(self._path, self._first):
            self._aside(self._path)
        file = AtomicAppendFile(self._path, append=True)
        try:
            file.lock(LOCK_TIMEOUT)
        except OSError:
            file.close()
            raise
        there = file.lines_from(due.written.end)
        self._file, self._due = file, None
        self.missing += due.written.missing
        if file.end == 0 and not (due.lines and due.lines[0][1] == due.first):
            self._owed = self._first
            self.missing += 1  # at least one: the former content is unknown
        for number, line in missing_lines(due.lines, there):
            try:
                self._write((line, 0, number))
            except OSError:
                self.dropped += 1
        last = max((number for number, _ in due.lines), default=due.written.number)
        self.written = WriteProgress(last, file.end, self.missing)

    def _write(self, item: tuple[str, int, int]) -> None:
        line, missed, number = item
        self.missing += missed
        try:
            self._begin()
            self._recreate_if_deleted()
            self._write_owed()
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
                self.written = WriteProgress(number, self._file.end, self.missing)

    def _recreate_if_deleted(self) -> None:
        assert self._file is not None
        if self._file.removed:
            self._file.recreate()
            self.missing, self.dropped, self._lines_in_file = (
                self.missing + self._lines_in_file,
                self.dropped + self._lines_in_file,
                0,
            )
            self._owed = self._first if self._mark is not None else b""

    def _write_owed(self) -> None:
        if self._owed:
            self._add(self._owed)
            self._owed = b""

    def _add(self, data: bytes) -> None:
        assert self._file is not None
        self._file.append(data)
        self.bytes += len(data)
        self._lines_in_file += data is not self._owed

    def _finish(self) -> None:
        if self._file is not None:
            self._file.close()


def missing_lines(lines: Sequence[tuple[int, str]], present: Sequence[bytes]) -> Sequence[tuple[int, str]]:
    """Return those of `lines` that follow the last one that is `present` (complete lines of a file, in the same order).

    Earlier lines that are not in the file were lost and are not written out of order. A line with a gap mark equals
    the line without it.
    """
    texts = [line.encode() for _, line in lines]
    places: dict[bytes, list[int]] = {}
    for place in range(len(texts) - 1, -1, -1):
        places.setdefault(texts[place], []).append(place)  # descending, so that pop() returns the first
    begin = 0
    for row in present:
        found = places.get(row) or places.get(without_mark(row)) or []
        while found and found[-1] < begin:
            found.pop()
        if found:
            begin = found.pop() + 1
    return lines[begin:]


def begins_with(path: Path, first: bytes) -> bool:
    """Whether a file begins with these bytes, or is empty or missing."""
    try:
        with path.open("rb") as file:
            head = file.read(len(first))
    except FileNotFoundError:
        return True
    return not head or head == first


GAP_KEY: Final = "gap"
"""Key in a journal line: number of lines missing before it."""


def with_gap(line: str, missing: int) -> str:
    """Return a journal line (one JSON object) with the number of lines missing before it."""
    return f'{line[:-1]},"{GAP_KEY}":{missing}}}'


def without_mark(row: bytes) -> bytes:
    """Return a line without the gap mark that `with_gap` adds."""
    head, comma, tail = row.rpartition(b',"gap":')
    return head + b"}" if comma and tail[:-1].isdigit() else row
