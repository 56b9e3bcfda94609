"""Tap tempo: a grid of beats from a sequence of taps."""

from statistics import fmean, median, median_low
from typing import Final

from live.clock.timeline import Grid

SEQUENCE_TIMEOUT: Final = 2.0
"""Seconds without a tap after which a new sequence begins."""

BOUNCE: Final = 0.15
"""Taps closer than this [s] (400 bpm) count as one: the key bounces."""

MIN_TAPS: Final = 3
MAX_TAPS: Final = 12


class TapTempo:
    """Collects taps; from the third on, each gives a grid."""

    def __init__(self) -> None:
        self._taps: list[float] = []

    @property
    def count(self) -> int:
        """Number of taps in the sequence so far."""
        return len(self._taps)

    def tap(self, time: float) -> Grid | None:
        """Add a tap at `time` [s]; return the grid through the taps, None for fewer than three.

        The period is the mean of the intervals within a quarter of their median, so that one missed or doubled tap
        changes nothing; the phase is the median over the taps.
        """
        if self._taps and abs(time - self._taps[-1]) > SEQUENCE_TIMEOUT:
            self._taps.clear()
        if self._taps and time - self._taps[-1] < BOUNCE:
            return None
        self._taps = [*self._taps[-(MAX_TAPS - 1) :], time]
        if len(self._taps) < MIN_TAPS:
            return None
        intervals = [later - earlier for earlier, later in zip(self._taps, self._taps[1:], strict=False)]
        middle = median_low(intervals)  # one of them, so that at least one lies near it
        grid = Grid(time, fmean(i for i in intervals if abs(i - middle) <= 0.25 * middle))
        shift = median(grid.residual(tap) for tap in self._taps)
        return Grid(time + shift * grid.period, grid.period)
