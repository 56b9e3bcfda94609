"""Limits for late and hung processes, and back-off for restarts."""

from collections import deque
from typing import Final

LATE_AFTER: Final = 0.5
"""Seconds without a heartbeat after which a process counts as late."""
HANGS_AFTER: Final = 2.0
"""Seconds of its own without a heartbeat after which a process is killed and replaced; see `watchdog.py`."""
MAX_SILENCE: Final = 20.0
"""Seconds without a heartbeat after which it is killed, however slow the machine is."""
SETTLED: Final = 60.0
"""A process that has run for so many seconds has got over any problem at its start."""
LEAVES_WITHIN: Final = 20.0
"""Seconds that closing may take: the end of a journal and of a film on a slow disk."""


class RestartLimit:
    """Limit of `most` restarts within `seconds`; beyond it the show changes to calm mode."""

    def __init__(self, most: int = 3, seconds: float = 30.0) -> None:
        self._seconds = seconds
        self._last: deque[float] = deque(maxlen=most)
        self.count = 0
        """Restarts since the start."""

    def record(self, now: float) -> bool:
        """Record a restart at `now` [s]; return True if the limit had been reached before it."""
        full = len(self._last) == self._last.maxlen and now - self._last[0] < self._seconds
        self._last.append(now)
        self.count += 1
        return full


class Backoff:
    """Exponential back-off with a ceiling for restarts.

    The first `free` starts are immediate; then the wait is `first` [s], doubled each time, up to `most`. After a run
    longer than `settled` [s] the count starts again.
    """

    def __init__(self, *, free: int = 1, first: float = 1.0, most: float = 60.0, settled: float = SETTLED) -> None:
        self._free, self._first, self._most, self._settled = free, first, most, settled
        self._count = 0
        self._due: float | None = None

    def next_delay(self, now: float) -> float:
        """Record an end at `now` [s]; return the seconds until the next start."""
        if self._due is not None and now - self._due > self._settled:
            self._count = 0
        over = self._count - self._free
        wait = 0.0 if over < 0 else min(self._first * 2.0 ** min(over, 32), self._most)
        self._count += 1
        self._due = now + wait
        return wait
