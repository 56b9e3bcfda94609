"""Which dancers come too near to each other on their ways, and when (T101, T147).

Mending ways whose dancers start at different times (T147).

Who travels together on straight ways of a squared-distance matching never meets anybody (CAPT); who starts earlier
or later may. Mended are first the times: two who would meet exchange their waits (a ripple keeps its look), or one
takes the other's; if nothing helps they and all who are tied to them start together, which is safe in the end. Then
the ways, by divide and conquer. What remains is said, for steering to see to.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.evolution_kernels import nearest_approach, sample_ways
from live.agents.evolutions.incremental_assignment import Pieces, at_once
from live.agents.evolutions.paths import dividing
from live.agents.evolutions.start_delays import Arrive, times
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


MARGIN = 0.045
"""Metres that bent ways leave between bodies: smoothing takes some of it back, and without it pairs remain."""


@dataclass(frozen=True, slots=True, eq=False)
class Mended:
    """A locomotion after mending."""

    locomotion: Locomotion
    waits: Float64
    """What each dancer waits now [beats], shape (D,)."""
    retimed: int
    """How many dancers wait longer or shorter than asked."""
    bent: bool
    """Whether ways were bent."""
    remaining: tuple[Approach, ...]
    """Pairs that still come too near: left to steering."""


class WaitMending:
    """Changes waits until nobody meets, a change at a time; `work` until `done`."""

    def __init__(self, clearance: Clearance, begin: float, end: float, waits: Float64, arrive: Arrive) -> None:
        """`clearance` has been looked at wholly; `waits` (D,) [beats] are those of its times."""
        self.waits = waits.copy()
        self._clearance = clearance
        self._begin, self._end, self._arrive = begin, end, arrive
        self._longest = float(waits.max(initial=0.0))
        self._tied = np.arange(len(waits))
        self._given_up = np.zeros((len(waits), len(waits)), np.bool_)
        self._left = 6 * len(waits)
        self.done = self._worst() is None

    def work(self) -> None:
        """Make one change, or find that none is left to make."""
        worst = self._worst()
        if worst is None or self._left <= 0:
            self.done = True
            return
        self._left -= 1
        i, j = worst
        wi, wj = float(self.waits[i]), float(self.waits[j])
        if abs(wi - wj) < 1e-9:  # they meet although they start together: their ways have to be bent
            self._given_up[i, j] = self._given_up[j, i] = True
            return
        before = self._count()
        for new_i, new_j in ((wj, wi), (wj, wj), (wi, wi)):
            self._set(i, new_i)
            self._set(j, new_j)
            if self._count() < before and self._tied[i] != self._tied[j]:
                return
        self._set(i, wi)
        self._set(j, wj)
        self._tie(i, j)

    def _tie(self, i: int, j: int) -> None:
        """They start together from now on, with all who are tied to either, as the larger of both parties does."""
        first, second = self._tied == self._tied[i], self._tied == self._tied[j]
        wait = self.waits[i] if first.sum() >= second.sum() else self.waits[j]
        both = first | second
        self._tied[both] = min(self._tied[i], self._tied[j])
        for dancer in np.flatnonzero(both):
            if self.waits[dancer] != wait:
                self._set(int(dancer), float(wait))

    def _set(self, dancer: int, wait: float) -> None:
        self.waits[dancer] = wait
        own = times(self._begin, self._end, np.array([wait]), self._arrive, self._longest)[0]
        self._clearance.retime(dancer, float(own[0]), float(own[1]))

    def _worst(self) -> tuple[int, int] | None:
        """The pair that comes nearest and can still be helped."""
        near = self._clearance.near() & ~self._given_up
        if not near.any():
            return None
        distance = np.where(near, self._clearance.distance, np.inf)
        i, j = np.unravel_index(int(np.argmin(distance)), distance.shape)
        return (int(i), int(j)) if i < j else (int(j), int(i))

    def _count(self) -> int:
        return int(self._clearance.near().sum())


def mended(
    locomotion: Locomotion,
    radius: npt.ArrayLike,
    waits: Float64,
    *,
    begin: float,
    end: float,
    arrive: Arrive = Arrive.TOGETHER,
    bend: bool = True,
    seed: int = 0,
    half: tuple[float, float] | None = None,
) -> Mended:
    """Look, change waits, bend ways (if `bend`), look again. `radius` (D,) or one [m]."""
    return at_once(
        mending(locomotion, radius, waits, begin=begin, end=end, arrive=arrive, bend=bend, seed=seed, half=half)
    )


def mending(
    locomotion: Locomotion,
    radius: npt.ArrayLike,
    waits: Float64,
    *,
    begin: float,
    end: float,
    arrive: Arrive = Arrive.TOGETHER,
    retime: bool = True,
    bend: bool = True,
    seed: int = 0,
    half: tuple[float, float] | None = None,
) -> Pieces[Mended]:
    """`mended` in pieces; without `retime` waits stay, without `bend` ways stay: then it only looks."""
    clearance = Clearance(locomotion, radius)
    yield from clearance.looking()
    wait_mending = WaitMending(clearance, begin, end, waits, arrive)
    while retime and not wait_mending.done:
        wait_mending.work()
        yield
    retimed = int((np.abs(wait_mending.waits - waits) > 1e-9).sum())
    result = replace(locomotion, times=clearance.times)
    remaining = clearance.approaches()
    bent = False
    if remaining and bend:
        clear = float(np.max(clearance.least)) + MARGIN
        candidate = yield from dividing(result, clear, seed=seed, half=half)
        again = Clearance(candidate, radius)
        yield from again.looking()
        after = again.approaches()
        if len(after) < len(remaining):
            result, remaining, bent = candidate, after, True
    return Mended(result, wait_mending.waits, retimed, bent, tuple(remaining))
