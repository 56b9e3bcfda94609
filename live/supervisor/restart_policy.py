"""When a process is late, when it hangs, and how often it is started again."""

from collections import deque
from typing import Final

LATE_AFTER: Final = 0.5
"""Seconds without a heartbeat after which a process counts as late."""
HANGS_AFTER: Final = 2.0
"""Seconds of its own without a heartbeat after which a process is ended and another started; see `watchdog.py`."""
CEILING: Final = 20.0
"""Seconds without a heartbeat after which it is killed however slow the machine is."""
SETTLED: Final = 60.0
"""What has run for so many seconds has got through whatever was wrong at its start."""
LEAVES_WITHIN: Final = 20.0
"""Seconds that closing may take: the end of a journal and of a film on a slow disk."""


class RestartLimit:
    """At most `most` restarts within `seconds`; more than that and the show has to become calmer.

    stage.md 4.7: three in thirty seconds.
    """

    def __init__(self, most: int = 3, seconds: float = 30.0) -> None:
        self._seconds = seconds
        self._last: deque[float] = deque(maxlen=most)
        self.count = 0
        """Restarts since the start."""

    def note(self, now: float) -> bool:
        """Note a restart at `now` [s]; True if those before it were as many as are allowed."""
        full = len(self._last) == self._last.maxlen and now - self._last[0] < self._seconds
        self._last.append(now)
        self.count += 1
        return full


class Backoff:
    """How long to wait before something is started again that ends too soon: exponential, with a ceiling.

    The first `free` starts come at once, then `first` [s] is waited, twice that, and so on, `most` at last. What has
    run for `settled` [s] begins from the front.
    """

    def __init__(self, *, free: int = 1, first: float = 1.0, most: float = 60.0, settled: float = SETTLED) -> None:
        self._free, self._first, self._most, self._settled = free, first, most, settled
        self._count = 0
        self._due: float | None = None

    def after(self, now: float) -> float:
        """It has ended at `now` [s]: seconds until it may be started again."""
        if self._due is not None and now - self._due > self._settled:
            self._count = 0
        over = self._count - self._free
        wait = 0.0 if over < 0 else min(self._first * 2.0 ** min(over, 32), self._most)
        self._count += 1
        self._due = now + wait
        return wait
