"""The fixed time step of the simulation (after bevy's fixed timestep).

64 Hz because 60 Hz beats against the monitor (0, 2, 0, 2 ticks a frame), and 1/64 s is exact in binary: tick n is
at n/64 s without rounding, at any frame rate.
"""

import math
from dataclasses import dataclass
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

    def is_due(self, target: float) -> bool:
        """Whether the next tick is at or before `target` [s]."""
        return (self.index + 1) * TICK <= target

    def advance(self) -> float:
        """Go on to the next tick; return its time [s]."""
        self.index += 1
        return self.time


@dataclass(frozen=True, slots=True)
class FrameGrid:
    """The frames of a film at `fps` [1/s], all on one grid of the whole show: frame k, from 0, shows it at k / fps [s],
    in the state after the last tick until then."""

    fps: float

    def time(self, frame: int) -> float:
        """Return the time of a frame [s of the show]."""
        return frame / self.fps

    def tick(self, frame: int) -> int:
        """Return the last tick at or before a frame."""
        return math.floor(self.time(frame) / TICK)

    def first_from(self, tick: int) -> int:
        """Return the first frame that shows a tick or a later one."""
        frame = max(math.floor(tick * TICK * self.fps) - 1, 0)
        while self.tick(frame) < tick:
            frame += 1
        return frame

    def count(self, seconds: float) -> int:
        """Return how many frames a film of `seconds` has, at least 1."""
        return max(1, math.ceil(seconds * self.fps))
