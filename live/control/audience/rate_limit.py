"""Why something that a phone sent was refused, and how much of it may come: counts by reason, and buckets."""

from enum import StrEnum
from typing import Final


class Why(StrEnum):
    """The reasons: a fixed list, so that no sender can make the counts grow."""

    HOST = "phone: foreign host"
    ORIGIN = "phone: page of another site"
    PATH = "phone: no such page"
    FULL = "phone: as many as there may be"
    ADDRESS = "phone: too many of one address"
    JOINS = "phone: joins too fast"
    LINK = "phone: old or wrong link"
    SPENT = "phone: code used up"
    TOKEN = "phone: wrong token"
    SILENT = "phone: did not say who it is"
    MALFORMED = "phone: malformed message"
    LONG = "phone: message too long"
    FAST = "phone: messages too fast"
    BUSY = "phone: too many messages in all"
    SLOW = "phone: does not listen"
    IDLE = "phone: said nothing for long"
    CLOSED = "phone: audience closed"


class Bucket:
    """So many at once, and so many a second."""

    __slots__ = ("_at", "_burst", "_left", "_rate")

    def __init__(self, rate: float, burst: float) -> None:
        self._rate, self._burst = rate, burst
        self._left, self._at = burst, 0.0

    def take(self, now: float) -> bool:
        """Whether there is room for one more at `now` [s]."""
        left = min(self._left + max(now - self._at, 0.0) * self._rate, self._burst)
        self._at = now
        if left < 1.0:
            self._left = left
            return False
        self._left = left - 1.0
        return True


class Line:
    """A line of those who wait: so many come in at once, and so many a second; whoever waits has her turn reserved.

    A virtual scheduling queue (GCRA, ITU-T I.371), so that it holds two numbers however many wait.
    """

    __slots__ = ("_next", "_rate", "_tolerance")

    def __init__(self, rate: float, burst: float) -> None:
        self._rate, self._tolerance = rate, (burst - 1.0) / rate
        self._next = -1e9

    def wait(self, now: float) -> float:
        """How long one more has to wait [s]."""
        return max(self._next - self._tolerance - now, 0.0)

    def reserve(self, now: float) -> None:
        """One more has its turn."""
        self._next = max(self._next, now) + 1.0 / self._rate


RATE: Final = 15.0
BURST: Final = 30.0
"""Messages of one phone a second, and at once."""
ALL_RATE: Final = 30_000.0
"""Messages of all together a second."""
ALL_BURST: Final = 6000.0
"""And at once."""
ALL_JOINS: Final = 400.0
"""Joins of all together a second."""
