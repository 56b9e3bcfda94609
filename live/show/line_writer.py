"""LineWriter: lines of text into a file by a thread of its own, so that the show never waits for the disk."""

from collections.abc import Callable
from pathlib import Path

from live.show.clerk import Clerk
from live.show.whole_writes import WholeWrites

CAPACITY = 65536
"""Lines that may wait for the disk."""


class LineWriter(Clerk[tuple[str, int]]):
    """Takes lines from the show's thread; when the disk is slow or full, lines are dropped and counted.

    Once there is room again it goes on, with the next line whole: each is there as a line or not at all. A file that
    was removed is made again. Thread: the file is touched only by the writer's own, after the start.
    """

    def __init__(
        self, path: Path, *, name: str, more: bool = False, mark: Callable[[str, int], str] | None = None
    ) -> None:
        """Raises OSError if the file cannot be made; `name` is the thread's; `more`: behind what the file holds.

        `mark` writes into a line how many before it are missing; then the first line, without which the others mean
        nothing, is never left out.
        """
        self._file = WholeWrites(path, more=more)
        self._mark = mark
        self._missed = 0  # that found too many waiting, since the last that did not
        self._first: bytes = b""
        self._owed: bytes = b""  # to be written before anything else
        self._there = 0
        self.missing = 0
        """Lines lost since the last one that was written."""
        self.lines, self.bytes = 0, 0
        """Lines taken, and bytes written, since the start."""
        super().__init__(name, CAPACITY)

    def line(self, line: str) -> None:
        """Hand over one line, without its end; never waits."""
        if self.put((line, self._missed)):
            self._missed = 0
            self.lines += 1
        else:
            self._missed += 1

    def _write(self, item: tuple[str, int]) -> None:
        line, missed = item
        self.missing += missed
        try:
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
        self._first = self._first or line.encode() + b"\n"
        self.missing = 0

    def _look_after_the_file(self) -> None:
        if self._file.removed:
            self._file.again()
            self.missing, self.dropped, self._there = self.missing + self._there, self.dropped + self._there, 0
            self._owed = self._first if self._mark is not None else b""

    def _settle(self) -> None:
        if self._owed:
            self._add(self._owed)
            self._owed = b""

    def _add(self, data: bytes) -> None:
        self._file.add(data)
        self.bytes += len(data)
        self._there += data is not self._owed

    def _finish(self) -> None:
        self._file.close()
