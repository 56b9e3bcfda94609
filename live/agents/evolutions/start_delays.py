"""Start delays of dancers: together, staggered, as a ripple, arriving on the measure line (T096, T147)."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64


class StartOrder(StrEnum):
    """In which order dancers start."""

    LEFT = "left"
    """From the left of the stage to the right, as the audience sees it."""
    RIGHT = "right"
    """From right to left."""
    FRONT = "front"
    """From the front to the back."""
    BACK = "back"
    """From the back to the front."""
    CENTRE = "centre"
    """From the middle of the group outwards."""
    OUTSIDE = "outside"
    """From outside inwards."""
    ID = "id"
    """By their numbers."""
    RANDOM = "random"
    """In random order, from the seed."""


class Arrival(StrEnum):
    """When dancers who start at different times arrive."""

    TOGETHER = "together"
    """All exactly at the end."""
    APART = "apart"
    """Each as long after their start as the others, the last one exactly at the end."""


@dataclass(frozen=True, slots=True)
class Ripple:
    """Starts spread over `beats` in an order; with 0 beats all start together."""

    beats: float = 0.0
    """Beats from the first start to the last; at most three quarters of the available time."""
    order: StartOrder = StartOrder.LEFT
    arrive: Arrival = Arrival.TOGETHER


TOGETHER: Final = Ripple()
"""All start at once."""


def delays(ripple: Ripple, start: npt.ArrayLike, numbers: npt.ArrayLike, *, seed: int = 0) -> Float64:
    """Return the beats that each dancer waits, shape (D,), from 0 to `ripple.beats`; equals start together.

    `start` (D, 2) [m] are their places, `numbers` (D,) their IDs, which also seed the random order. Delays are spread
    evenly over the different values, so a grid starts row by row.
    """
    places = np.asarray(start, np.float64)
    ids = np.asarray(numbers)
    if len(places) == 0 or ripple.beats <= 0.0:
        return np.zeros(len(places))
    key = np.round(_key(ripple.order, places, ids, seed), 3)  # differences under a millimetre count as one row
    different, rank = np.unique(key, return_inverse=True)
    return np.asarray(ripple.beats * rank.reshape(-1) / max(len(different) - 1, 1), np.float64)


def _key(order: StartOrder, places: Float64, ids: npt.NDArray[np.generic], seed: int) -> Float64:
    x, z = places[:, 0], places[:, 1]
    if order is StartOrder.LEFT:
        return np.asarray(x)
    if order is StartOrder.RIGHT:
        return np.asarray(-x)
    if order is StartOrder.FRONT:
        return np.asarray(-z)
    if order is StartOrder.BACK:
        return np.asarray(z)
    if order in (StartOrder.CENTRE, StartOrder.OUTSIDE):
        distance = np.hypot(*(places - places.mean(axis=0)).T)
        return np.asarray(distance if order is StartOrder.CENTRE else -distance)
    if order is StartOrder.ID:
        return np.asarray(ids, np.float64)
    chance = [int(np.random.default_rng([seed, int(number)]).integers(1 << 40)) for number in ids]
    return np.asarray(chance, np.float64)


def limit_delays(wait: npt.ArrayLike, time: float) -> Float64:
    """Scale all waits (D,) by one factor if the longest would leave less than a quarter of `time` [beats]."""
    waits = np.maximum(np.asarray(wait, np.float64), 0.0)
    longest = float(waits.max(initial=0.0))
    return waits if longest <= 0.75 * time else waits * (0.75 * time / longest)


def start_and_arrival(
    begin: float, end: float, waits: Float64, arrive: Arrival = Arrival.TOGETHER, longest: float | None = None
) -> Float64:
    """Return the beats at which each dancer starts and arrives, (D, 2), for `waits` (D,) [beats] of `limit_delays`.

    `longest` is the wait of the last dancer to arrive when they arrive apart; by default the longest of `waits`.
    """
    if arrive is Arrival.TOGETHER:
        arrival = np.full(len(waits), float(end))
    else:
        arrival = end - (float(waits.max(initial=0.0)) if longest is None else longest) + waits
    return np.stack([begin + waits, arrival], axis=1)
