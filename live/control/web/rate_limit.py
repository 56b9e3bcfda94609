"""Limit on the number of messages of one sender."""


class RateLimit:
    """Lets through `per_second` messages, and as many at once."""

    def __init__(self, per_second: float) -> None:
        self._most = self._left = per_second
        self._filled_at = 0.0

    def try_take(self, now: float) -> bool:
        """Whether one more message may pass at `now` [s]."""
        self._left = min(self._left + (now - self._filled_at) * self._most, self._most)
        self._filled_at = now
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True
