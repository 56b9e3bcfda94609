"""Allowance: how many values may act in a frame, so that a flood of them costs a frame little (a token bucket).

A hand, or a program that means well, never notices. In a flood there are fewer than else: what each value costs is the
frame's, and of one that is replaced a thousand times a second hardly one more is worth that.
"""

from typing import Final

BURST: Final = 128.0
PER_SECOND: Final = 512.0
"""Values: so many at once, after a pause, and so many more each second ..."""
FLOODED_PER_SECOND: Final = 128.0
"""... or only so many, ..."""
FLOOD: Final = 4000.0
"""... while more than these come in a second."""
ROUND: Final = 0.25
"""Seconds over which what is offered is counted."""


class Allowance:
    """One taker's. Thread: one."""

    def __init__(self) -> None:
        self._left, self._rate = BURST, PER_SECOND
        self._filled_at = self._counted_at = 0.0
        self._counted = 0

    def left(self, now: float, offered: int) -> int:
        """How many may act at `now` [s]; `offered`: how many have come since the start, acted upon or not."""
        if now - self._counted_at >= ROUND:
            flooded = offered - self._counted > FLOOD * (now - self._counted_at)
            self._rate = FLOODED_PER_SECOND if flooded else PER_SECOND
            self._counted, self._counted_at = offered, now
        self._left = min(self._left + max(now - self._filled_at, 0.0) * self._rate, BURST)
        self._filled_at = now
        return int(self._left)

    def spend(self, count: int) -> None:
        """So many acted."""
        self._left = max(self._left - count, 0.0)
