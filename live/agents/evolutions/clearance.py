"""Which dancers come too near to each other on their ways, and when (T101, T147)."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.evolutions_kernels import nearest_approach, sample_ways
from live.agents.evolutions.pieces import Pieces
from live.agents.evolutions.trajectory import Float32, Float64, Locomotion

PIECE = 200_000
"""Looks at a pair at a time that make one piece of work: about a millisecond."""
SAMPLES = 65
"""Times at which ways are looked at; between them dancers are taken to go straight."""
TOLERANCE = 0.005
"""Metres that bodies may overlap without being called too near."""


@dataclass(frozen=True, slots=True)
class Approach:
    """Two dancers (rows of a locomotion) who come nearer than their bodies: at which beat, how near [m]."""

    first: int
    second: int
    beat: float
    distance: float


class Clearance:
    """The nearest approach of every two of D dancers; rows can be looked at in pieces, and again after a change."""

    def __init__(self, locomotion: Locomotion, radius: npt.ArrayLike, samples: int = SAMPLES) -> None:
        """`radius` is the body radius [m], shape (D,) or one for all."""
        count = locomotion.count
        self.ways, self.soft = locomotion.ways, locomotion.soft
        self.times = locomotion.times.copy()
        self.beats = np.linspace(locomotion.begin, locomotion.end, samples)
        self.sample: Float32 = np.zeros((samples, count, 2), np.float32)
        bodies = np.broadcast_to(np.asarray(radius, np.float64), (count,))
        self.least: Float64 = bodies[:, None] + bodies[None, :] - TOLERANCE
        """How near two may come [m], shape (D, D)."""
        self.distance: Float32 = np.full((count, count), np.inf, np.float32)
        """How near they come [m], shape (D, D)."""
        self._when: Float32 = np.zeros((count, count), np.float32)
        sample_ways(self.beats, self.ways, self.times, self.soft, 0, count, self.sample)

    def look(self, first: int, last: int) -> None:
        """Fill the rows `first` to `last` (not included)."""
        nearest_approach(self.sample, first, last, self.distance, self._when)

    def looking(self) -> Pieces[None]:
        """Fill all rows, in pieces."""
        count = len(self.ways)
        rows = max(1, PIECE // max(1, count * len(self.beats)))
        for first in range(0, count, rows):
            self.look(first, min(first + rows, count))
            yield

    def retime(self, dancer: int, begin: float, end: float) -> None:
        """One dancer travels at other times: her row and column are looked at anew."""
        self.times[dancer] = begin, end
        sample_ways(self.beats, self.ways, self.times, self.soft, dancer, dancer + 1, self.sample)
        self.look(dancer, dancer + 1)
        self.distance[:, dancer] = self.distance[dancer]
        self._when[:, dancer] = self._when[dancer]

    def near(self) -> npt.NDArray[np.bool_]:
        """Who is too near to whom at some time, shape (D, D)."""
        return np.asarray(self.distance < self.least)

    def approaches(self) -> list[Approach]:
        """All pairs that come too near, the nearest first."""
        first, second = np.nonzero(np.triu(self.near(), 1))
        order = np.lexsort((second, first, self.distance[first, second]))
        step = (self.beats[-1] - self.beats[0]) / (len(self.beats) - 1)
        return [
            Approach(int(i), int(j), float(self.beats[0] + step * self._when[i, j]), float(self.distance[i, j]))
            for i, j in zip(first[order], second[order], strict=True)
        ]


def approaches(locomotion: Locomotion, radius: npt.ArrayLike, samples: int = SAMPLES) -> list[Approach]:
    """All pairs of dancers who come nearer than their bodies on these ways, the nearest first."""
    clearance = Clearance(locomotion, radius, samples)
    clearance.look(0, locomotion.count)
    return clearance.approaches()
