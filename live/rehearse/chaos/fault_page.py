"""Shared memory page of a chaos run: the run requests faults in it, and processes report their progress.

It is a file, so it outlives every process, and raised faults are counted over all of them. Each word is written
atomically by one writer. Two processes that raise at the same moment may raise once too often, which is harmless.
"""

import mmap
import os
import struct
from enum import IntEnum
from pathlib import Path
from typing import Final

WORDS: Final = 64
_WORD: Final = struct.Struct("=q")


class PageWord(IntEnum):
    """Index of a word in the page; each word is a signed number of 64 bits."""

    SITE = 0
    """Number of the call site of the tick that fails, from 1; 0: none."""
    LEFT = 1
    """Remaining number of exceptions at the site."""
    SINCE = 2
    """First tick at which the site fails."""
    RAISED = 3
    """Number of exceptions raised at the site."""
    THREAD = 4
    """Number of the last request to raise an exception in a thread; incremented for each request."""
    THREAD_WHICH = 5
    """Selects the thread of the process."""
    THREAD_DONE = 6
    """Number of the last completed request."""
    CALLS = 7
    """Remaining number of calls of services outside the show that fail."""
    CALLS_WHICH = 8
    """Selects the call in a frame."""
    CALLS_RAISED = 9
    DISK = 10
    """Error number raised by every write of the journal; 0: none."""
    CLOCK = 11
    """Error of the system clock [ms]."""
    CUT = 12
    """Process whose channel to its supervisor is to be cut."""
    FRAMES = 13
    """Number of frames in which an active engine ran ticks."""
    LAST = 14
    """Time of the last such frame [ns, monotonic]."""
    TICK = 15
    """Last tick."""
    GAP = 16
    """Longest interval between two such frames since this word was set to 0 [ns]."""
    PID = 17
    """Process that ran the last tick."""
    REPEATED_TICKS = 18
    """Number of ticks that were run again after they were over."""


class FaultPage:
    """The memory-mapped page. Thread: any."""

    def __init__(self, path: Path, *, make: bool = False) -> None:
        """Raises OSError if it cannot be created, or does not exist."""
        flags = os.O_RDWR | (os.O_CREAT | os.O_TRUNC if make else 0)
        descriptor = os.open(path, flags, 0o600)
        try:
            if make:
                os.ftruncate(descriptor, WORDS * _WORD.size)
            self._page = mmap.mmap(descriptor, WORDS * _WORD.size)
        finally:
            os.close(descriptor)
        self._words = memoryview(self._page).cast("q")

    def __getitem__(self, word: PageWord) -> int:
        return self._words[word]

    def __setitem__(self, word: PageWord, value: int) -> None:
        self._words[word] = value

    def close(self) -> None:
        """Unmap the page."""
        self._words.release()
        self._page.close()
