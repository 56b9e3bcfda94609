"""Mending ways whose dancers start at different times (T147).

Who travels together on straight ways of a squared-distance matching never meets anybody (CAPT); who starts earlier
or later may. Mended are first the times: two who would meet exchange their waits (a ripple keeps its look), or one
takes the other's; if nothing helps they and all who are tied to them start together, which is safe in the end. Then
the ways, by divide and conquer. What remains is said, for steering to see to.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.clearance import Approach, Clearance
from live.agents.evolutions.divide import dividing
from live.agents.evolutions.pieces import Pieces, at_once
from live.agents.evolutions.start_delays import Arrive, times
from live.agents.evolutions.trajectory import Float64, Locomotion

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
