"""LinkClock: which second of the show belongs to which microsecond of Ableton Link's clock."""

import math
from collections import deque
from collections.abc import Callable
from typing import Final

WINDOW: Final = 16
"""Readings kept for the rate: with one each quarter of a second, four seconds."""

TRIES: Final = 5
GOOD: Final = 5e-6
"""A reading is tried again, five times at most, until it is bracketed within 5 µs."""

WIDE: Final = 200e-6
"""A reading that was interrupted for longer is not taken while a good one is younger than ..."""

OLD: Final = 2.0
"""... these seconds."""

COUNTED: Final = 1e-6
"""Link counts whole microseconds: two readings may be this much nearer or farther apart than they say [s]."""

RATE_LIMIT: Final = 2e-3
"""The two clocks run apart by at most 500 ppm (what NTP may slew) and two crystals; more is a mistake."""


class LinkClock:
    """Link counts CLOCK_MONOTONIC_RAW, the show the slewed CLOCK_MONOTONIC: they drift apart, and NTP bends the drift.

    A reading is Link's clock between two looks at the show's, so its error is known: at most half of what lies
    between the two. The newest good reading is therefore taken as it is, and the readings before it give only the
    rate at which to go on from there. (A line fitted through all of them would be late where NTP changes the rate.)
    Thread: one at a time.
    """

    def __init__(self) -> None:
        self._readings: deque[tuple[float, float, float]] = deque(maxlen=WINDOW)  # Link's seconds, offset, half width
        self._rate = 0.0

    @property
    def error(self) -> float:
        """Bound on the error [s] of the newest reading; infinite before the first."""
        return self._readings[-1][2] if self._readings else math.inf

    @property
    def rate(self) -> float:
        """How much faster the show's clock runs than Link's: 1e-6 is one ppm."""
        return self._rate

    def read(self, micros: Callable[[], int], now: Callable[[], float]) -> None:
        """Read both clocks, as narrowly as may be."""
        best: tuple[float, int, float] | None = None
        for _ in range(TRIES):
            before = now()
            ticks = micros()
            after = now()
            if best is None or after - before < best[2] - best[0]:
                best = (before, ticks, after)
            if after - before <= GOOD:
                break
        assert best is not None
        self.observe(*best)

    def observe(self, before: float, micros: int, after: float) -> None:
        """Link's clock showed `micros` between `before` and `after` [s of the show]."""
        link, half = micros * 1e-6, 0.5 * (after - before)
        if half > WIDE and self._readings and link - self._readings[-1][0] < OLD and self.error < half:
            return
        self._readings.append((link, 0.5 * (before + after) - link, half))
        if len(self._readings) > 1:
            first = self._readings[0]
            span = link - first[0]
            slack = first[2] + half + COUNTED  # a slope that brackets and counting could have made alone is none
            rise = self._readings[-1][1] - first[1]
            rise = math.copysign(max(abs(rise) - slack, 0.0), rise)
            self._rate = min(max(rise / span, -RATE_LIMIT), RATE_LIMIT) if span > 0.0 else 0.0

    def time_of(self, micros: float) -> float:
        """Seconds of the show at which Link's clock shows `micros`."""
        link, offset, _ = self._readings[-1]
        at = micros * 1e-6
        return at + offset + self._rate * (at - link)
