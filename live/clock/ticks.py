"""The fixed time step of the simulation (after bevy's fixed timestep).

64 Hz because 60 Hz beats against the monitor (0, 2, 0, 2 ticks a frame), and 1/64 s is exact in binary: tick n is
at n/64 s without rounding, at any frame rate.
"""

import math
from collections.abc import Iterator
from typing import Final

TICK: Final = 1.0 / 64.0
"""Seconds from one tick to the next."""

STALL: Final = 0.25
"""After a gap longer than this [s] the missed ticks are skipped and counted, not run."""


class TickCounter:
    """Counts ticks up to a target time; the tick with index n is at n/64 s.

    Thread: the show's only.
    """

    def __init__(self, index: int = 0, *, stall: float = STALL) -> None:
        """`stall`: gaps longer than this [s] are skipped; infinite where no tick may be skipped (offline)."""
        self._stall = stall
        self.index = index
        """Index of the last tick that was due (the state of the simulation)."""
        self.skipped = 0
        """Ticks skipped after stalls, since the start."""

    @property
    def time(self) -> float:
        """Seconds at the last due tick."""
        return self.index * TICK

    def stalled(self, target: float) -> int:
        """Return how many ticks to skip because `target` [s] lies more than a stall ahead; usually 0."""
        behind = target - self.time
        return math.floor(behind / TICK) - 1 if behind > self._stall else 0

    def skip(self, count: int) -> None:
        """Skip `count` ticks."""
        self.index += count
        self.skipped += count

    def due(self, target: float) -> Iterator[float]:
        """Yield the times [s] of the ticks after the last one, up to and including `target` [s]."""
        while (self.index + 1) * TICK <= target:
            self.index += 1
            yield self.index * TICK
