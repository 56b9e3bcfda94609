"""Range: where a value lies among those that this room has shown so far."""

from typing import Final

FORGET: Final = 0.003
"""Share by which the ends come together with each value."""

RISES: Final = 0.5
"""Share of the way that an end goes with a value beyond it, so that single values count for less."""


class Range:
    """A lowest and a highest value that widen at once and narrow slowly; values come as 0 to 1 between them."""

    def __init__(self, narrowest: float, widest: float, *, first: float = 1.0) -> None:
        """`narrowest`, `widest`: of the range. `first`: where in it the first value lies, 0 to 1."""
        self._narrowest, self._widest, self._first = narrowest, widest, first
        self.low = self.high = 0.0
        """The ends."""
        self._known = False

    def add(self, value: float, *, lowest: bool = True) -> float:
        """Widen the range to a value, and say where it lies, 0 to 1. `lowest`: whether it may lower the range.

        So that pauses, which are no quiet music, do not.
        """
        if not self._known:
            self._known = True
            self.low = value - self._first * self._narrowest
            self.high = self.low + self._narrowest
        middle, half = 0.5 * (self.low + self.high), 0.5 * (self.high - self.low) * (1.0 - FORGET)
        self.low, self.high = middle - half, middle + half
        if value > self.high:
            self.high += RISES * (value - self.high)
        elif value < self.low and lowest:
            self.low += RISES * (value - self.low)
        if self.high - self.low < self._narrowest:
            grow = 0.5 * (self._narrowest - (self.high - self.low))
            self.low, self.high = self.low - grow, self.high + grow
        self.low = max(self.low, self.high - self._widest)
        return min(max((value - self.low) / (self.high - self.low), 0.0), 1.0)
