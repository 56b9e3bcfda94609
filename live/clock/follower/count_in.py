"""Count-in: measures that are counted before a downbeat."""

import math
from typing import Final

ARMED_FOR: Final = 30.0
"""Time for which a count-in waits for taps [s]."""


class CountIn:
    """Counts beats down to the downbeat."""

    def __init__(self) -> None:
        self._measures = 0
        self._armed_until = -math.inf
        self._now = -math.inf
        self._downbeat: float | None = None

    @property
    def armed(self) -> bool:
        """Whether it waits for a measure of taps."""
        return self._now < self._armed_until

    def arm(self, measures: int, time: float) -> None:
        """Prepare a count of this many measures, to begin once there is a beat."""
        self._measures, self._armed_until, self._now = measures, time + ARMED_FOR, time
        self._downbeat = None

    def begin(self, first: int, beats_per_measure: int) -> None:
        """Begin the count at the beat `first`."""
        self._armed_until = -math.inf
        self._downbeat = float(first + self._measures * beats_per_measure)

    def update(self, beat: float, now: float) -> bool:
        """Update at each tick; return True when the downbeat has come."""
        self._now = now
        if self._downbeat is None or beat < self._downbeat:
            return False
        self._downbeat = None
        return True

    def remaining(self, beat: float) -> int:
        """Return the beats still to be counted, this one included; 0 without a count-in."""
        return 0 if self._downbeat is None else math.ceil(self._downbeat - beat)
