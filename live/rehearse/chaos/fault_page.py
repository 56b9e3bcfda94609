"""FaultPage: a page of shared memory in which a chaos run says what is to fail, and processes say how they fare.

It is a file, so that it outlives every process: how often a fault was raised is counted over all of them. Words are
written whole by one writer each; two processes that raise in the same moment may raise once too often, which does no
harm.
"""

import mmap
import os
import struct
from enum import IntEnum
from pathlib import Path
from typing import Final

WORDS: Final = 64
_WORD: Final = struct.Struct("=q")


class Word(IntEnum):
    """What is in the page, each a signed number of 64 bits."""

    SITE = 0
    """Which call site of the tick fails, from 1; 0: none ..."""
    LEFT = 1
    """... how often it is still to ..."""
    SINCE = 2
    """... from which tick on ..."""
    RAISED = 3
    """... and how often it has."""
    THREAD = 4
    """An order to raise in a thread: its number is counted up, ..."""
    THREAD_WHICH = 5
    """... which of the process' threads ..."""
    THREAD_DONE = 6
    """... and the last order that was carried out."""
    CALLS = 7
    """So many calls of parts beside the show are still to fail ..."""
    CALLS_WHICH = 8
    """... of those that are called one after the other in a frame, this one."""
    CALLS_RAISED = 9
    DISK = 10
    """The error number with which every write of the journal ends; 0: none."""
    CLOCK = 11
    """Milliseconds by which the system's clock is wrong."""
    CUT = 12
    """The process whose wire to its supervisor is to be cut."""
    FRAMES = 13
    """Rounds of ticks that were run by engines that dance, ..."""
    LAST = 14
    """... when the last one was [ns, monotonic], ..."""
    TICK = 15
    """... the tick at which it ended, ..."""
    GAP = 16
    """... and the longest time between two since this was set to 0 [ns]."""
    PID = 17
    """The process that danced last."""
    BACK = 18
    """How often a tick was run again that was over: the dance went back."""


class FaultPage:
    """The page. Thread: any."""

    def __init__(self, path: Path, *, make: bool = False) -> None:
        """OSError if it cannot be made, or is not there."""
        flags = os.O_RDWR | (os.O_CREAT | os.O_TRUNC if make else 0)
        descriptor = os.open(path, flags, 0o600)
        try:
            if make:
                os.ftruncate(descriptor, WORDS * _WORD.size)
            self._page = mmap.mmap(descriptor, WORDS * _WORD.size)
        finally:
            os.close(descriptor)
        self._words = memoryview(self._page).cast("q")

    def __getitem__(self, word: Word) -> int:
        return self._words[word]

    def __setitem__(self, word: Word, value: int) -> None:
        self._words[word] = value

    def close(self) -> None:
        """Give it back."""
        self._words.release()
        self._page.close()
