"""Assignment of dancers to slots, by ID or by least cost (T097-T100; CAPT), with reserved slots (T093, T104)."""

from collections.abc import Sequence, Set
from enum import StrEnum

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64, Int32

Mask = npt.NDArray[np.bool_]


class Cost(StrEnum):
    """The quantity that an assignment minimizes."""

    SQUARED = "squared"
    """The sum of squared distances (CAPT: Turpin, Michael, Kumar 2014): synchronous straight paths never meet."""
    SHORTEST = "shortest"
    """The sum of distances, W_min (T098, Schulz 2011, 4.3.2)."""
    EQUAL = "equal"
    """How much each path differs from the mean path of the shortest assignment, W_equal (T099)."""
    BOTH = "both"
    """A weighted sum of the last two, W_both (T100)."""
    BOTTLENECK = "bottleneck"
    """The longest path, then the sum of squares."""


class Fill(StrEnum):
    """Which slots stay empty if there are fewer dancers than slots."""

    NEAREST = "nearest"
    """Those that cost most to reach."""
    IN_ORDER = "in order"
    """The last ones of the formation."""


def distances(start: npt.ArrayLike, slots: npt.ArrayLike) -> Float64:
    """Return the distance [m] from each start (D, 2) to each slot (S, 2), shape (D, S)."""
    difference = np.asarray(start, np.float64)[:, None, :] - np.asarray(slots, np.float64)[None, :, :]
    return np.asarray(np.hypot(difference[..., 0], difference[..., 1]))


def assign(
    start: npt.ArrayLike,
    slots: npt.ArrayLike,
    *,
    cost: Cost = Cost.SQUARED,
    equal_weight: float = 0.5,
    allowed: Mask | None = None,
    fill: Fill = Fill.NEAREST,
) -> Int32:
    """Return the slot of each dancer, shape (D,): exact, within a tick for up to about 200 dancers.

    `start` (D, 2) and `slots` (S, 2) [m]. -1 means no slot: there are more dancers than slots, or no slot that is
    `allowed` (D, S) is left; as many dancers as possible get one. `equal_weight` (0 to 1) is the weight of W_equal in
    `Cost.BOTH`; 0.5 is the thesis' plain sum.
    """
    metres = distances(start, slots)
    if metres.size == 0:
        return np.full(len(metres), -1, np.int32)
    possible = np.ones(metres.shape, np.bool_) if allowed is None else allowed
    taken = _order_price(metres.shape) if fill is Fill.IN_ORDER and metres.shape[0] < metres.shape[1] else None
    if cost is Cost.BOTTLENECK:
        possible = possible & (metres <= _longest_needed(metres, possible, taken))
    return _solve(_weights(metres, cost, equal_weight, possible, taken), possible, taken)


def by_id(dancers: int, slots: int) -> Int32:
    """Assign the first dancer to the first slot and so on, shape (D,): the declared matching (T097)."""
    own = np.arange(dancers, dtype=np.int32)
    return np.where(own < slots, own, -1).astype(np.int32)


def _weights(metres: Float64, cost: Cost, equal_weight: float, possible: Mask, order_price: Float64 | None) -> Float64:
    if cost in (Cost.SQUARED, Cost.BOTTLENECK):
        return metres * metres
    if cost is Cost.SHORTEST:
        return metres
    shortest = _solve(metres, possible, order_price)
    who = np.flatnonzero(shortest >= 0)
    mean = float(metres[who, shortest[who]].mean()) if len(who) else 0.0  # the first of two passes (T099)
    equal = np.abs(metres - mean)
    if cost is Cost.EQUAL:
        return np.asarray(equal)
    return np.asarray((1.0 - equal_weight) * metres + equal_weight * equal)


def _solve(weights: Float64, possible: Mask, order_price: Float64 | None) -> Int32:
    """Minimize the sum. Impossible pairs cost more than all others together, so they come last and are removed."""
    from scipy.optimize import linear_sum_assignment

    if order_price is None and possible.all():
        rows, columns = linear_sum_assignment(weights)
        slot = np.full(weights.shape[0], -1, np.int32)
        slot[rows] = columns
        return slot
    unit = float(weights.max(initial=0.0) + 1.0) * min(weights.shape)
    total = weights / unit
    if order_price is not None:
        total = total + order_price
    beyond = (float(total.max(initial=0.0)) + 1.0) * (min(weights.shape) + 1)
    rows, columns = linear_sum_assignment(np.where(possible, total, beyond))
    slot = np.full(weights.shape[0], -1, np.int32)
    real = possible[rows, columns]
    slot[rows[real]] = columns[real]
    return slot


def _order_price(shape: tuple[int, int]) -> Float64:
    """Return a price that rises with the slot number by more than all paths together (`_solve` keeps those under 1).

    The sets of slots that can be filled form a matroid, so the least sum of numbers is also the set that fills the
    slots in order wherever possible.
    """
    return np.broadcast_to(np.arange(shape[1], dtype=np.float64), shape)


def _longest_needed(metres: Float64, possible: Mask, order_price: Float64 | None) -> float:
    """Return the smallest limit on path length with which as many dancers get a slot as without one (bisection)."""
    full = _solve(np.zeros_like(metres), possible, order_price)
    wanted = (int((full >= 0).sum()), int(full.clip(0).sum()) if order_price is not None else 0)
    candidates = np.unique(metres[possible])
    low, high = 0, len(candidates) - 1
    while low < high:
        middle = (low + high) // 2
        slot = _solve(np.zeros_like(metres), possible & (metres <= candidates[middle]), order_price)
        found = (int((slot >= 0).sum()), int(slot.clip(0).sum()) if order_price is not None else 0)
        if found == wanted:
            high = middle
        else:
            low = middle + 1
    return float(candidates[low]) if len(candidates) else 0.0


UNRESERVED = 0
"""The section of slots without a mark, and of dancers without a matching mark."""


def sections(attributes: Sequence[Set[str]], marks: Sequence[str]) -> tuple[Int32, Int32]:
    """Return the section of each dancer (D,) and of each slot (S,), as numbers; `UNRESERVED` where no mark matches.

    `attributes` are those of each dancer, `marks` one word per slot ("": any dancer). A dancer belongs to the
    first mark, in slot order, that is one of their attributes.
    """
    names = list(dict.fromkeys(mark for mark in marks if mark))
    number = {name: index + 1 for index, name in enumerate(names)}
    dancer = [next((number[name] for name in names if name in own), UNRESERVED) for own in attributes]
    return np.array(dancer, np.int32), np.array([number.get(mark, UNRESERVED) for mark in marks], np.int32)
