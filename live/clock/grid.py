"""Grid: where the beats lie, as a hypothesis: numbered, evenly spaced, with no measures yet."""

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Grid:
    """Beat `number` lies at `time` [s], the others `period` [s] apart."""

    time: float
    period: float
    number: int = 0

    @property
    def tempo(self) -> float:
        """Beats per minute."""
        return 60.0 / self.period

    def beat_at(self, time: float) -> float:
        """Beat at `time` [s]."""
        return self.number + (time - self.time) / self.period

    def residual(self, time: float, division: float = 1.0) -> float:
        """How far `time` [s] lies after the nearest line of a grid of `division` beats, in beats (± division / 2)."""
        position = (time - self.time) / (self.period * division)
        return (position - math.floor(position + 0.5)) * division

    def numbered_like(self, beat: float, time: float) -> "Grid":
        """The same grid, its beats numbered so that `time` [s] is as near to `beat` as can be."""
        return Grid(self.time, self.period, self.number + math.floor(beat - self.beat_at(time) + 0.5))
