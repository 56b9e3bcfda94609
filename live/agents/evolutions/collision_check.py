"""Detection and repair of collisions between dancers on planned paths (T101, T147).

Dancers who start together on straight paths of a squared-distance assignment never collide (CAPT); with different
start times they may. The repair first changes times: two dancers who would collide exchange their waits (a ripple
keeps its look), or one takes the other's; if nothing helps, they and all dancers tied to them start together. Then
paths are bent by divide and conquer. Remaining pairs are reported and left to steering.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.evolution_kernels import longest_moves, nearest_approach, sample_paths
from live.agents.evolutions.incremental_assignment import Pieces
from live.agents.evolutions.paths import bend_paths_in_pieces
from live.agents.evolutions.start_delays import Arrival, start_and_arrival
from live.agents.evolutions.trajectory import Locomotion
from live.base.arrays import Float32, Float64

PAIRS_PER_PIECE = 600_000
"""Pairs, times the moments at which paths are sampled, in one piece of work: half a millisecond, as most moments are
skipped."""
LARGEST_REPAIRED = 1000
"""With more dancers than this, pairs are not looked for, as there are millions: all is left to steering."""
SAMPLES = 65
"""Times at which paths are sampled; between them dancers are assumed to move straight."""
TOLERANCE = 0.005
"""Metres that bodies may overlap without being reported."""


@dataclass(frozen=True, slots=True)
class Approach:
    """Two dancers (rows of a locomotion) whose bodies would touch: at which beat, and how near the centres are [m]."""

    first: int
    second: int
    beat: float
    distance: float


class Clearance:
    """The nearest approach of all pairs of D dancers; rows are computed in pieces and updated after a change."""

    def __init__(
        self, locomotion: Locomotion, radius: npt.ArrayLike, samples: int = SAMPLES, *, exact: bool = True
    ) -> None:
        """`radius` is the body radius [m], shape (D,) or one for all. Unless `exact`, distances of pairs that do not
        come too near are those at some time.
        """
        count = locomotion.count
        self.path_knots, self.soft = locomotion.path_knots, locomotion.ramp
        self.times = locomotion.times.copy()
        self.beats = np.linspace(locomotion.begin, locomotion.end, samples)
        self.sample: Float32 = np.zeros((samples, count, 2), np.float32)
        bodies = np.broadcast_to(np.asarray(radius, np.float64), (count,))
        self.min_distance: Float64 = bodies[:, None] + bodies[None, :] - TOLERANCE
        """Minimum allowed distance [m], shape (D, D)."""
        self.distance: Float32 = np.full((count, count), np.inf, np.float32)
        """Smallest distance on the paths [m], shape (D, D)."""
        self._when: Float32 = np.zeros((count, count), np.float32)
        self._reach = np.inf if exact else float(self.min_distance.max(initial=0.0))
        self._step: Float64 = np.zeros(count)
        self._sample(0, count)

    def _sample(self, first: int, last: int) -> None:
        sample_paths(self.beats, self.path_knots, self.times, self.soft, first, last, self.sample)
        longest_moves(self.sample, first, last, self._step)

    def compute_rows(self, first: int, last: int) -> None:
        """Compute the rows `first` to `last` (not included)."""
        nearest_approach(self.sample, self._step, self._reach, first, last, self.distance, self._when)

    def compute_all(self) -> Pieces[None]:
        """Compute all rows, in pieces."""
        count = len(self.path_knots)
        rows = max(1, PAIRS_PER_PIECE // max(1, count * len(self.beats)))
        for first in range(0, count, rows):
            self.compute_rows(first, min(first + rows, count))
            yield

    def retime(self, dancer: int, begin: float, end: float) -> None:
        """Change the times of one dancer and recompute their row and column."""
        self.times[dancer] = begin, end
        self._sample(dancer, dancer + 1)
        self.compute_rows(dancer, dancer + 1)
        self.distance[:, dancer] = self.distance[dancer]
        self._when[:, dancer] = self._when[dancer]

    def too_near(self) -> npt.NDArray[np.bool_]:
        """Return which pairs are too near at some time, shape (D, D)."""
        return np.asarray(self.distance < self.min_distance)

    def approaches(self) -> list[Approach]:
        """Return all pairs that come too near, the nearest first."""
        first, second = np.nonzero(np.triu(self.too_near(), 1))
        order = np.lexsort((second, first, self.distance[first, second]))
        step = (self.beats[-1] - self.beats[0]) / (len(self.beats) - 1)
        return [
            Approach(int(i), int(j), float(self.beats[0] + step * self._when[i, j]), float(self.distance[i, j]))
            for i, j in zip(first[order], second[order], strict=True)
        ]


MARGIN = 0.045
"""Metres that bent paths leave between bodies: smoothing takes some back, and without the margin pairs remain."""


@dataclass(frozen=True, slots=True, eq=False)
class RepairResult:
    """A locomotion after collision repair."""

    locomotion: Locomotion
    waits: Float64
    """Wait of each dancer now [beats], shape (D,)."""
    retimed: int
    """Number of dancers who wait longer or shorter than requested."""
    bent: bool
    """Whether paths were bent."""
    remaining: tuple[Approach, ...]
    """Pairs that still come too near: left to steering."""


class WaitRepair:
    """Changes waits one at a time until there are no collisions; call `work` until `done`."""

    def __init__(self, clearance: Clearance, begin: float, end: float, waits: Float64, arrive: Arrival) -> None:
        """`clearance` is fully computed; `waits` (D,) [beats] are those of its times."""
        self.waits = waits.copy()
        self._clearance = clearance
        self._begin, self._end, self._arrive = begin, end, arrive
        self._longest = float(waits.max(initial=0.0))
        self._tie_group = np.arange(len(waits))
        self._given_up = np.zeros((len(waits), len(waits)), np.bool_)
        self._left = 6 * len(waits)
        self.done = self._worst() is None

    def work(self) -> None:
        """Make one change, or set `done` if none is left."""
        worst = self._worst()
        if worst is None or self._left <= 0:
            self.done = True
            return
        self._left -= 1
        i, j = worst
        wi, wj = float(self.waits[i]), float(self.waits[j])
        if abs(wi - wj) < 1e-9:  # they collide although they start together: only bending the paths helps
            self._given_up[i, j] = self._given_up[j, i] = True
            return
        before = self._count()
        for new_i, new_j in ((wj, wi), (wj, wj), (wi, wi)):
            self._set(i, new_i)
            self._set(j, new_j)
            if self._count() < before and self._tie_group[i] != self._tie_group[j]:
                return
        self._set(i, wi)
        self._set(j, wj)
        self._tie(i, j)

    def _tie(self, i: int, j: int) -> None:
        """Let both start together from now on, with all dancers tied to either, at the wait of the larger party."""
        first, second = self._tie_group == self._tie_group[i], self._tie_group == self._tie_group[j]
        wait = self.waits[i] if first.sum() >= second.sum() else self.waits[j]
        both = first | second
        self._tie_group[both] = min(self._tie_group[i], self._tie_group[j])
        for dancer in np.flatnonzero(both):
            if self.waits[dancer] != wait:
                self._set(int(dancer), float(wait))

    def _set(self, dancer: int, wait: float) -> None:
        self.waits[dancer] = wait
        own = start_and_arrival(self._begin, self._end, np.array([wait]), self._arrive, self._longest)[0]
        self._clearance.retime(dancer, float(own[0]), float(own[1]))

    def _worst(self) -> tuple[int, int] | None:
        """Return the pair that comes nearest and that retiming may still separate."""
        near = self._clearance.too_near() & ~self._given_up
        if not near.any():
            return None
        distance = np.where(near, self._clearance.distance, np.inf)
        i, j = np.unravel_index(int(np.argmin(distance)), distance.shape)
        return (int(i), int(j)) if i < j else (int(j), int(i))

    def _count(self) -> int:
        return int(self._clearance.too_near().sum())


def repair_in_pieces(
    locomotion: Locomotion,
    radius: npt.ArrayLike,
    waits: Float64,
    *,
    begin: float,
    end: float,
    arrive: Arrival = Arrival.TOGETHER,
    retime: bool = True,
    bend: bool = True,
    seed: int = 0,
    half: tuple[float, float] | None = None,
) -> Pieces[RepairResult]:
    """Check, change waits (if `retime`), bend paths (if `bend`), check again. `radius` (D,) or one [m]."""
    if locomotion.count > LARGEST_REPAIRED:
        return RepairResult(locomotion, waits, 0, False, ())
    clearance = Clearance(locomotion, radius, exact=False)
    yield from clearance.compute_all()
    wait_mending = WaitRepair(clearance, begin, end, waits, arrive)
    while retime and not wait_mending.done:
        wait_mending.work()
        yield
    retimed = int((np.abs(wait_mending.waits - waits) > 1e-9).sum())
    result = replace(locomotion, times=clearance.times)
    remaining = clearance.approaches()
    bent = False
    if remaining and bend:
        clear = float(np.max(clearance.min_distance)) + MARGIN
        candidate = yield from bend_paths_in_pieces(result, clear, seed=seed, half=half)
        again = Clearance(candidate, radius, exact=False)
        yield from again.compute_all()
        after = again.approaches()
        if len(after) < len(remaining):
            result, remaining, bent = candidate, after, True
    return RepairResult(result, wait_mending.waits, retimed, bent, tuple(remaining))
