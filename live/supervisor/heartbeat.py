"""Heartbeat of a process in shared memory; neither the writer nor the reader ever waits."""

import time
from enum import IntEnum

from live.base.system.shared_page import SharedPage


class Phase(IntEnum):
    """Phase of a process."""

    STARTING = 0
    """It need not send heartbeats."""
    WAITING = 1
    """It is ready and waits to be needed."""
    RUNNING = 2
    """It sends a heartbeat each frame or round."""
    LEAVING = 3
    """It closes its files and devices."""


class Heartbeat:
    """Aligned words in a shared page: time, tick and phase of the last beat, and the running tick and its stage.

    Each word is written atomically. A reader may see a new tick with an old time, which does no harm. Thread: any, one
    writer.
    """

    def __init__(self, page: SharedPage | None = None) -> None:
        """Use the page of the process that watches, or make a new one."""
        self.page = SharedPage.create() if page is None else page
        self._words = memoryview(self.page.memory).cast("Q")
        self._stage = self._words[3:4]

    def beat(self, tick: int, phase: Phase) -> None:
        """Record a heartbeat with tick and phase."""
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
        """The word of the running stage, written by the show (`CircuitBreakers.publish`)."""
        return self._stage

    def begin_tick(self, tick: int) -> None:
        """Record that tick `tick` starts, which also counts as a heartbeat."""
        self._words[4] = tick
        self._words[0] = time.monotonic_ns()

    @property
    def running(self) -> tuple[int, int]:
        """The tick that was started last, and its running stage; 0: it has finished."""
        return self._words[4], self._words[3]

    def close(self) -> None:
        """Release the memory."""
        self._stage.release()
        self._words.release()
        self.page.close()
