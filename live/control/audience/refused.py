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
    TOKEN = "phone: wrong token"
    SILENT = "phone: did not say who it is"
    MALFORMED = "phone: malformed message"
    LONG = "phone: message too long"
    FAST = "phone: messages too fast"
    BUSY = "phone: too many messages in all"
    SLOW = "phone: does not listen"
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


RATE: Final = 15.0
BURST: Final = 30.0
"""Messages of one phone a second, and at once."""
ALL_RATE: Final = 30_000.0
"""Messages of all together a second."""
ALL_BURST: Final = 6000.0
"""And at once."""
JOIN_RATE: Final = 4.0
JOIN_BURST: Final = 2.0
"""Joins of one address a second and at once, times how many phones it may have, in parts of 16."""
ALL_JOINS: Final = 400.0
"""Joins of all together a second."""
