"""Limit on values processed in a frame (a token bucket), so that a flood of values costs a frame little.

Manual operation and normal programs stay below it. In a flood the limit is lower than usual: each value costs frame
time, and of a value that is replaced a thousand times a second only few are needed.
"""

from typing import Final

BURST: Final = 128.0
PER_SECOND: Final = 512.0
"""Values per second in the long run; after a pause `BURST` values at once."""
FLOODED_PER_SECOND: Final = 128.0
"""Values per second during a flood ..."""
FLOOD_RATE: Final = 4000.0
"""... which is more than this many values offered per second."""
FLOOD_WINDOW: Final = 0.25
"""Seconds over which the offered values are counted."""


class ProcessingBudget:
    """The limit of one consumer. Thread: one."""

    def __init__(self) -> None:
        self._left, self._rate = BURST, PER_SECOND
        self._filled_at = self._counted_at = 0.0
        self._counted = 0

    def remaining(self, now: float, received_count: int) -> int:
        """Return how many values may be processed at `now` [s]; `received_count`: values received since the start,
        processed or not."""
        if now - self._counted_at >= FLOOD_WINDOW:
            flooded = received_count - self._counted > FLOOD_RATE * (now - self._counted_at)
            self._rate = FLOODED_PER_SECOND if flooded else PER_SECOND
            self._counted, self._counted_at = received_count, now
        self._left = min(self._left + max(now - self._filled_at, 0.0) * self._rate, BURST)
        self._filled_at = now
        return int(self._left)

    def spend(self, count: int) -> None:
        """Count processed values."""
        self._left = max(self._left - count, 0.0)
