"""LineWriter: lines of text into a file by a thread of its own, so that the show never waits for the disk."""

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from live.show.journal.clerk import Clerk
from live.show.journal.whole_writes import WholeWrites

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
