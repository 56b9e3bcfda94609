"""Slot assignment for any number of dancers, done in pieces so that no frame waits for it (T097).

An exact assignment of 1,000 dancers takes 50 ms and more. Here both sets are halved repeatedly along the longer side
of their bounding box until an exact assignment of the parts is fast. Then pairs of dancers swap their slots as long
as that reduces the sum of squared path lengths. The clearance proof of CAPT only needs that no pair can be improved,
so it holds for thousands of dancers as for fifty.

Long work is written as generators (`Pieces`) that yield after each piece and return the result.
"""

from collections.abc import Callable, Generator
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.evolution_kernels import swap_pairs
from live.agents.evolutions.slot_assignment import UNRESERVED, Cost, Fill, assign
from live.base.arrays import Float64, Int32

Index = npt.NDArray[np.intp]

LEAF = 64
"""Dancers of a part that is assigned at once."""
MAX_EXACT = 128
"""Up to this many dancers of one section are assigned at once and exactly: at most about a millisecond."""
PAIRS_PER_PIECE = 60_000
"""Pairs examined in one piece."""
SWEEPS = 40
"""Maximum sweeps over all pairs; five to ten are usually needed."""
MAX_PAIRS = 60_000_000
"""Pairs examined in all, some 70 ms of work: the best assignment of up to 3,000 dancers, a good one of more."""
MAX_URGENT_PAIRS = 2_000_000
"""Pairs that are still examined in a hurry: 300 dancers get their best slots even then."""


class IncrementalAssignment:
    """One assignment, done in pieces: ``begin``, then ``work`` until ``done``; then `slot` holds the result."""

    def __init__(self) -> None:
        self.slot: Int32 = np.zeros(0, np.int32)
        """Slot of each dancer, shape (D,); -1: none."""
        self._pieces: list[Callable[[], None]] = []

    def begin(
        self,
        start: npt.ArrayLike,
        slots: npt.ArrayLike,
        *,
        cost: Cost = Cost.SQUARED,
        equal_weight: float = 0.5,
        fill: Fill = Fill.NEAREST,
        dancer_section: Int32 | None = None,
        slot_section: Int32 | None = None,
        exact: int = MAX_EXACT,
    ) -> None:
        """Match dancers at `start` (D, 2) with `slots` (S, 2) [m]; sections as in `sections`, by default one for all.

        Each section is matched with its own slots; dancers who find none there get the remaining unmarked slots.
        """
        self._start = np.ascontiguousarray(start, np.float64).reshape(-1, 2)
        self._slots = np.ascontiguousarray(slots, np.float64).reshape(-1, 2)
        self._cost, self._weight, self._fill, self._exact = cost, equal_weight, fill, exact
        dancers, places = len(self._start), len(self._slots)
        self._dancer_section = np.zeros(dancers, np.int32) if dancer_section is None else dancer_section
        self._slot_section = np.zeros(places, np.int32) if slot_section is None else slot_section
        self.slot = np.full(dancers, -1, np.int32)
        self._sweep, self._row, self._swapped, self._pairs_left = 0, 0, 0, MAX_PAIRS
        self._section: Int32 | None = None
        self._pieces = []
        named = [int(s) for s in np.unique(self._dancer_section) if s != UNRESERVED]
        # the list is a stack: named sections are done first, then the remaining dancers with the unmarked slots
        self._pieces.append(self._divide_remaining)
        for section in reversed(named):
            who, where = self._dancer_section == section, self._slot_section == section
            if where.any():
                self._divide(np.flatnonzero(who), np.flatnonzero(where))

    @property
    def done(self) -> bool:
        """Whether `slot` is the result."""
        return not self._pieces

    def work(self) -> None:
        """Do one piece, at most a millisecond or two."""
        if self._pieces:
            self._pieces.pop()()

    def hurry(self) -> None:
        """Take what is found soon: the swaps of thousands of dancers are cut short."""
        self._pairs_left = min(self._pairs_left, MAX_URGENT_PAIRS)

    def finish(self) -> Int32:
        """Complete the assignment at once and return it."""
        while not self.done:
            self.work()
        return self.slot

    def _divide_remaining(self) -> None:
        large = len(self._start) > self._exact
        if large and self._cost is Cost.SQUARED and len(self._slots):
            self._pieces.append(self._swap)
        left = np.flatnonzero(self.slot < 0)
        places = np.flatnonzero(self._slot_section == UNRESERVED)
        if len(left) and len(places):
            self._divide(left, places)

    def _divide(self, who: Index, where: Index) -> None:
        if min(len(who), len(where)) == 0:
            return
        if max(len(who), len(where)) <= self._exact:
            self._pieces.append(lambda: self._assign(who, where))
            return
        if len(who) != len(where):
            who, where = self._equalize(who, where)
        self._pieces.append(lambda: self._halve(who, where))

    def _assign(self, who: Index, where: Index) -> None:
        slot = assign(self._start[who], self._slots[where], cost=self._cost, equal_weight=self._weight, fill=self._fill)
        found = slot >= 0
        self.slot[who[found]] = where[slot[found]]

    def _equalize(self, who: Index, where: Index) -> tuple[Index, Index]:
        """Reduce to equal numbers: those nearest to the centre of the others, or the first slots in order."""
        if len(who) > len(where):
            return _nearest(who, self._start, self._slots[where].mean(axis=0), len(where)), where
        if self._fill is Fill.IN_ORDER:
            return who, where[: len(who)]
        return who, _nearest(where, self._slots, self._start[who].mean(axis=0), len(who))

    def _halve(self, who: Index, where: Index) -> None:
        if len(who) <= LEAF:
            self._assign(who, where)
            return
        both = np.concatenate([self._start[who], self._slots[where]])
        axis = int(np.argmax(np.ptp(both, axis=0)))
        first, second = _sorted_by(who, self._start, axis), _sorted_by(where, self._slots, axis)
        half = len(first) // 2
        self._pieces.append(lambda: self._halve(first[half:], second[half:]))
        self._pieces.append(lambda: self._halve(first[:half], second[:half]))

    def _swap(self) -> None:
        """Do one piece of a sweep over all pairs and push the next piece, until a whole sweep changes nothing."""
        count = len(self._start)
        last, pairs = self._row, 0
        while last < count and (pairs == 0 or pairs + count - last <= PAIRS_PER_PIECE):
            pairs += count - last
            last += 1
        if self._section is None:  # swaps are within sections, and do not change it
            free = self._slot_section[self.slot] == UNRESERVED
            self._section = np.where(free, UNRESERVED, self._dancer_section).astype(np.int32)
        self._swapped += swap_pairs(self._start, self._slots, self.slot, self._section, self._row, last)
        self._row = last
        self._pairs_left -= pairs
        if self._pairs_left <= 0:
            return
        if last >= count:
            self._sweep += 1
            if self._swapped == 0 or self._sweep >= SWEEPS:
                return
            self._row = self._swapped = 0
        self._pieces.append(self._swap)


def _nearest(index: Index, places: Float64, middle: npt.NDArray[np.float64], count: int) -> Index:
    distance = np.hypot(*(places[index] - middle).T)
    return np.sort(index[np.lexsort((index, distance))[:count]])


def _sorted_by(index: Index, places: Float64, axis: int) -> Index:
    """Return `index` sorted by one coordinate, ties by the other one, then by number."""
    return index[np.lexsort((index, places[index, 1 - axis], places[index, axis]))]


Result = TypeVar("Result")
Pieces = Generator[None, None, Result]


def run_to_end(pieces: Pieces[Result]) -> Result:
    """Run all pieces and return the result."""
    while True:
        try:
            next(pieces)
        except StopIteration as stop:
            result: Result = stop.value
            return result
