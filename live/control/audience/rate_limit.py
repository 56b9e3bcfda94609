"""Reasons for refusing phone messages, and rate limiters."""

from enum import StrEnum
from typing import Final


class RefusalReason(StrEnum):
    """Reasons for refusal. The list is fixed, so that no sender can make the counters grow."""

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


class TokenBucket:
    """Token bucket with a burst size and a rate per second."""

    __slots__ = ("_at", "_burst", "_left", "_rate")

    def __init__(self, rate: float, burst: float) -> None:
        self._rate, self._burst = rate, burst
        self._left, self._at = burst, 0.0

    def try_take(self, now: float) -> bool:
        """Take a token if one is available at `now` [s]; return whether it was."""
        left = min(self._left + max(now - self._at, 0.0) * self._rate, self._burst)
        self._at = now
        if left < 1.0:
            self._left = left
            return False
        self._left = left - 1.0
        return True


class WaitingLine:
    """Waiting line with reserved slots: a burst at once, then a rate per second.

    A virtual scheduling queue (GCRA, ITU-T I.371): it stores two numbers for any length.
    """

    __slots__ = ("_next", "_rate", "_tolerance")

    def __init__(self, rate: float, burst: float) -> None:
        self._rate, self._tolerance = rate, (burst - 1.0) / rate
        self._next = -1e9

    def wait(self, now: float) -> float:
        """Return the wait for the next slot [s]."""
        return max(self._next - self._tolerance - now, 0.0)

    def reserve(self, now: float) -> None:
        """Reserve the next slot."""
        self._next = max(self._next, now) + 1.0 / self._rate


RATE: Final = 15.0
BURST: Final = 30.0
"""Messages per second of one phone, and at once."""
ALL_RATE: Final = 30_000.0
"""Messages per second of all phones together."""
ALL_BURST: Final = 6000.0
"""Messages at once of all phones together."""
ALL_JOINS: Final = 400.0
"""Joins per second of all phones together."""
