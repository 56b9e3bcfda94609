"""When a process is late, when it hangs, and how often it is started again."""

from collections import deque
from dataclasses import dataclass
from typing import Final

LATE_AFTER: Final = 0.5
"""Seconds without a heartbeat after which a process counts as late."""
HANGS_AFTER: Final = 2.0
"""Seconds without a heartbeat after which it is killed and started again."""
LEAVES_WITHIN: Final = 20.0
"""Seconds that closing may take: the end of a journal and of a film on a slow disk."""


@dataclass(slots=True)
class Watch:
    """Judges heartbeats; counts each time that one was late."""

    late: int = 0
    """How often it was late, since the start."""
    _is_late: bool = False

    def judge(self, age: float) -> bool:
        """Whether a process whose last beat was `age` [s] ago hangs."""
        late = age > LATE_AFTER
        self.late += late and not self._is_late
        self._is_late = late
        return age > HANGS_AFTER


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
