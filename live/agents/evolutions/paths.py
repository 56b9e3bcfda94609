"""Paths of a group on the floor: straight, along a drawn line, in single file (T101, T103).

Paths whose dancers would collide are bent apart by divide and conquer (T101, Schulz 2011, 4.3.2, after Perlin).
"""

from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.evolution_kernels import (
    count_collisions,
    longest_steps,
    sample_paths,
    separate_paths_at,
    smooth_paths,
)
from live.agents.evolutions.incremental_assignment import Pieces
from live.agents.evolutions.trajectory import Locomotion
from live.base.arrays import Float32, Float64
from live.base.errors import PersonError

KNOTS: Final = 65
"""Knots of a drawn path."""
MAX_KNOTS: Final = 1025
"""Maximum number of knots of a path drawn with many points."""


def knots_for(polyline: npt.ArrayLike, least: int = KNOTS) -> int:
    """Return a number of knots, at least `least`, that keeps a drawn line of many points (N, 2) as fine as it is."""
    knots = least
    while knots < min(len(np.asarray(polyline)), MAX_KNOTS):
        knots = 2 * knots - 1
    return knots


def straight_paths(start: npt.ArrayLike, goal: npt.ArrayLike) -> Float32:
    """Return straight paths from `start` to `goal`, both (D, 2) [m]: knots of shape (D, 2, 2)."""
    ends = np.stack([np.asarray(start, np.float64), np.asarray(goal, np.float64)], axis=1)
    return np.ascontiguousarray(ends, np.float32)


def resample_polyline(polyline: npt.ArrayLike, knots: int = KNOTS) -> Float64:
    """Return `knots` points at equal arc lengths along a polyline (N, 2) [m], including both ends."""
    points = np.asarray(polyline, np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) == 0 or not np.isfinite(points).all():
        raise PersonError("a drawn path needs points [x, z] of finite metres")
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    if length[-1] < 1e-9:
        return np.repeat(points[:1], knots, axis=0)
    at = np.linspace(0.0, length[-1], knots)
    return np.stack([np.interp(at, length, points[:, 0]), np.interp(at, length, points[:, 1])], axis=1)


def parallel_paths(polyline: npt.ArrayLike, start: npt.ArrayLike) -> Float32:
    """Return paths on which each dancer follows the drawn path from their own place, shape (D, K, 2).

    The formation keeps its shape. Only the displacement from the first point of `polyline` (N, 2) matters.
    """
    way = resample_polyline(polyline, knots_for(polyline))
    places = np.asarray(start, np.float64)
    return np.ascontiguousarray(places[:, None, :] + (way - way[0])[None], np.float32)


def single_file(
    polyline: npt.ArrayLike, start: npt.ArrayLike, *, gap: float = 0.8, knots: int | None = None
) -> Float32:
    """Return paths along a drawn line in single file, one dancer after the other: knots (D, K, 2).

    The dancer nearest to the start of the line goes first and stops at its end; the others follow `gap` [m] apart.
    Each walks straight from their own place and reaches the start of the line when it is their turn. The knots lie at
    equal lengths of the *first* dancer's path, so all dancers must travel with the same times.
    """
    knots = knots_for(polyline, 129) if knots is None else knots
    places = np.asarray(start, np.float64).reshape(-1, 2)
    way = resample_polyline(polyline, max(knots, 257))
    at = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(way, axis=0).T))])
    order = np.argsort(np.hypot(*(places - way[0]).T), kind="stable")
    ways = np.empty((len(places), knots, 2), np.float32)
    approach = float(np.hypot(*(places[order[0]] - way[0]))) if len(order) else 0.0
    gone = np.linspace(0.0, approach + at[-1], knots)
    for rank, dancer in enumerate(order):
        turn = approach + rank * gap  # distance that the first has travelled when this one reaches the line's start
        share = np.clip(gone / max(turn, 1e-9), 0.0, 1.0)[:, None] if turn > 0.0 else np.ones((knots, 1))
        coming = places[dancer] + share * (way[0] - places[dancer])
        along = np.stack([np.interp(gone - turn, at, way[:, 0]), np.interp(gone - turn, at, way[:, 1])], axis=1)
        ways[dancer] = np.where((gone >= turn)[:, None], along, coming)
        if turn == 0.0:
            ways[dancer, 0] = places[dancer]
    return np.ascontiguousarray(ways)


LEVELS = 6
"""Levels of subdivision: the times 1/2, then 1/4 and 3/4, ... down to 1/64 are examined."""
SMOOTHING = 6
"""Passes of the filter 1/4, 1/2, 1/4 after paths have been separated."""
ROUNDS = 24
"""Maximum rounds of separating and smoothing. The thesis does one; smoothing can bring dancers together again."""
DIRECTION_RANDOMNESS = 0.0
"""How random the direction of a shift is: 1 is any direction, as in the thesis; 0 is perpendicular to the relative
motion with a random side. With 0, ten dancers who swap places through one point get past each other; with 1 not."""
PAIRS_PER_PIECE = 200_000
"""Pair checks in one piece of work: about a millisecond."""


def bend_paths_in_pieces(
    locomotion: Locomotion,
    clear: float,
    *,
    seed: int = 0,
    rounds: int = ROUNDS,
    smoothing: int = SMOOTHING,
    randomness: float = DIRECTION_RANDOMNESS,
    half: tuple[float, float] | None = None,
) -> Pieces[Locomotion]:
    """Bend paths so that dancers keep `clear` [m] between their centres where possible; same seed, same paths.

    The round with the fewest colliding pairs is kept (the earliest of equals). The knots of the result lie at even
    *times* and include the speeds of the input. `half` keeps paths on the stage [m]. Starts and goals stay.
    """
    begin, end = locomotion.begin, locomotion.end
    beats = np.linspace(begin, end, 2**LEVELS + 1)
    count = locomotion.count
    sample = np.zeros((len(beats), count, 2), np.float32)
    sample_paths(beats, locomotion.path_knots, locomotion.times, locomotion.ramp, 0, count, sample)
    ways = np.ascontiguousarray(sample.transpose(1, 0, 2))
    offset = np.zeros_like(ways)
    low = -np.array(half if half is not None else (np.inf, np.inf), np.float32)
    best, fewest = ways.copy(), (yield from _count_collisions(ways, clear))
    for turn in range(rounds):
        if fewest == 0:
            break
        yield from separate_in_pieces(ways, offset, clear, 1.15 + 0.05 * turn, randomness, seed + turn)
        for _ in range(smoothing):
            smooth_paths(offset)
        ways += offset
        if half is not None:
            np.clip(ways[:, 1:-1], low, -low, out=ways[:, 1:-1])
        meeting = yield from _count_collisions(ways, clear)
        if meeting < fewest:
            best, fewest = ways.copy(), meeting
    times = np.repeat(np.array([[begin, end]]), count, axis=0)
    return replace(locomotion, path_knots=best, times=times, ramp=0.0)


def separate_in_pieces(
    ways: Float32, offset: Float32, clear: float, excess: float, randomness: float, seed: int
) -> Pieces[int]:
    """Compute offsets (D, K, 2) [m] that separate colliding paths `ways` (D, K, 2), by divide and conquer (T101).

    Of the K = 2^L + 1 even times, 1/2, then 1/4 and 3/4, and so on are examined: see `separate_paths_at`. Later levels
    start from the means of the shifts of the levels before. Returns how many pairs were separated.
    """
    offset[:] = 0.0
    count, knots = ways.shape[:2]
    half, parted, checked = (knots - 1) // 2, 0, 0
    while half >= 1:
        for k in range(half, knots - 1, 2 * half):
            parted += separate_paths_at(ways, offset, k, half, clear, excess, randomness, seed)
            checked += count * count // 2
            if checked >= PAIRS_PER_PIECE:
                checked = 0
                yield
        half //= 2
    yield
    return parted


def _count_collisions(ways: Float32, clear: float) -> Pieces[int]:
    """Count the pairs that come nearer than `clear` [m]."""
    count, times = ways.shape[:2]
    rows, meeting = max(1, PAIRS_PER_PIECE // max(1, count * times)), 0
    step = np.zeros(count)
    longest_steps(ways, step)
    for first in range(0, count, rows):
        meeting += count_collisions(ways, step, first, min(first + rows, count), clear)
        yield
    return meeting
