"""WholeWrites: a file to which pieces are added that are there whole or not at all, whatever the disk does."""

import contextlib
import os
import sys
import time
from pathlib import Path
from typing import Final

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
