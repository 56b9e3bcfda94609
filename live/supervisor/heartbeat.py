"""Heartbeat: a process says in shared memory that it lives; whoever watches it reads, and neither ever waits."""

import mmap
import os
import time
from enum import IntEnum
from typing import Final

SIZE: Final = 4096


class Phase(IntEnum):
    """What a process is doing."""

    STARTING = 0
    """Nothing is expected of it but that it lives."""
    WAITING = 1
    """Everything is made; it waits to be needed."""
    RUNNING = 2
    """It beats each frame or round."""
    LEAVING = 3
    """It closes what it has open."""


class Heartbeat:
    """Aligned words in a page of memory that two processes share: when, tick, phase, and the stage of which tick runs.

    Each word is written at once; a reader may see a new tick with an old time, which does no harm. Thread: any, one
    writer.
    """

    def __init__(self, descriptor: int | None = None) -> None:
        """A new page, or (in the process that is watched) the one behind an inherited `descriptor`."""
        if descriptor is None:
            descriptor = os.memfd_create("heartbeat", 0)
            os.ftruncate(descriptor, SIZE)
        self.descriptor = descriptor
        """To be inherited by the process that is watched."""
        self._page = mmap.mmap(descriptor, SIZE)
        self._words = memoryview(self._page).cast("Q")
        self._stage = self._words[3:4]

    def beat(self, tick: int, phase: Phase) -> None:
        """I live, and stand at `tick`."""
        self._words[1] = tick
        self._words[2] = phase
        self._words[0] = time.monotonic_ns()

    @property
    def tick(self) -> int:
        """The tick of the last beat."""
        return self._words[1]

    @property
    def phase(self) -> Phase:
        """The phase of the last beat."""
        return Phase(self._words[2])

    @property
    def last(self) -> float:
        """When the last beat was [s, monotonic]; 0 before the first."""
        return self._words[0] / 1e9

    @property
    def stage(self) -> memoryview:
        """The word for the stage that runs now: a show writes it by itself (`Breakers.publish`)."""
        return self._stage

    def begin_tick(self, tick: int) -> None:
        """The tick `tick` is run now, which is a beat as well."""
        self._words[4] = tick
        self._words[0] = time.monotonic_ns()

    @property
    def running(self) -> tuple[int, int]:
        """The tick that was begun last, and the stage in which it is; 0: it is over."""
        return self._words[4], self._words[3]

    def close(self) -> None:
        """Give the memory back."""
        self._stage.release()
        self._words.release()
        self._page.close()
        os.close(self.descriptor)
