"""Deaths: where engines ended, and what the next one is told so that it does not end there, too.

The supervisor sees the tick and the stage that ran in the engine's page of shared memory, however it ended: by an
error, a signal, a hang that was ended, or for want of memory. It needs no array for that.
"""

from collections import deque
from typing import Any, Final

from live.alive.limits import RestartLimit

IN_ROW: Final = 3
"""So many engines that ended in one stage within `SECONDS` put it out of service, in whatever ticks that was."""
SECONDS: Final = 30.0


class Deaths:
    """Judges the ends of one show's engines. Thread: the supervisor's."""

    def __init__(self) -> None:
        self.count = 0
        """Engines that ended, since the start."""
        self._outside = RestartLimit()
        self._last: tuple[int, int] | None = None
        self._times = 0
        self._stages: deque[tuple[float, int]] = deque(maxlen=IN_ROW - 1)

    def note(self, now: float, tick: int, stage: int) -> tuple[dict[str, Any], bool]:
        """An engine ended at `now` [s] in `stage` of `tick`, 0: in none; what the next one is told of it, and whether
        devices, of which no tick knows, have to be left alone from now on (stage.md 4.7: three in thirty seconds)."""
        self.count += 1
        if not stage:
            self._last, self._times = None, 0
            return {"tick": tick, "stage": 0, "times": 1, "trip": False}, self._outside.note(now)
        self._times = self._times + 1 if self._last == (tick, stage) else 1
        self._last = tick, stage
        before = [one for when, one in self._stages if now - when < SECONDS]
        trip = len(before) == IN_ROW - 1 and all(one == stage for one in before)
        self._stages.append((now, stage))
        return {"tick": tick, "stage": stage, "times": self._times, "trip": trip}, False
