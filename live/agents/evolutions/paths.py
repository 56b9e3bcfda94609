"""Ways on the floor: straight, along a drawn line, in single file (T101, T103).

Divide and conquer: ways that meet are bent apart (T101, Schulz 2011, 4.3.2, after Perlin).
"""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.evolution_kernels import count_meetings, longest_steps, part_ways, sample_ways, smooth_ways
from live.agents.evolutions.incremental_assignment import Pieces, at_once
from live.agents.evolutions.trajectory import Locomotion
from live.base.errors import PersonError

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]

KNOTS = 65
"""Knots of a drawn way."""


def straight(start: npt.ArrayLike, goal: npt.ArrayLike) -> Float32:
    """Straight ways from `start` to `goal`, both (D, 2) [m]: knots of shape (D, 2, 2)."""
    ends = np.stack([np.asarray(start, np.float64), np.asarray(goal, np.float64)], axis=1)
    return np.ascontiguousarray(ends, np.float32)


def even(polyline: npt.ArrayLike, knots: int = KNOTS) -> Float64:
    """`knots` points at even lengths along a polyline (N, 2) [m], the first and the last being its ends."""
    points = np.asarray(polyline, np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) == 0 or not np.isfinite(points).all():
        raise PersonError("a drawn way needs points [x, z] of finite metres")
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    if length[-1] < 1e-9:
        return np.repeat(points[:1], knots, axis=0)
    at = np.linspace(0.0, length[-1], knots)
    return np.stack([np.interp(at, length, points[:, 0]), np.interp(at, length, points[:, 1])], axis=1)


def svg_path(data: str, *, metres_per_unit: float = 1.0, knots: int = 257) -> Float64:
    """An SVG path (the text of its attribute d) as a polyline (N, 2) [m]; down in the drawing is to the audience."""
    import svgpathtools

    try:
        path = svgpathtools.parse_path(data)
        lengths = [segment.length() for segment in path]
    except Exception as error:  # svgpathtools raises whatever its parsing meets
        raise PersonError(f"SVG path {data[:40]!r} cannot be read: {error}") from error
    if not path or not 0.0 < sum(lengths) < np.inf:
        raise PersonError(f"SVG path {data[:40]!r} draws nothing")
    points: list[complex] = []
    for segment, length in zip(path, lengths, strict=True):
        share = max(2, round(knots * length / sum(lengths)))
        points.extend(segment.point(t) for t in np.linspace(0.0, 1.0, share))
    flat = np.array([[point.real, point.imag] for point in points]) * metres_per_unit
    if not np.isfinite(flat).all():
        raise PersonError(f"SVG path {data[:40]!r} leads to infinity")
    return flat


def shifted(polyline: npt.ArrayLike, start: npt.ArrayLike, knots: int = KNOTS) -> Float32:
    """Everybody goes the drawn way from her own place, so the formation is carried along; shape (D, knots, 2).

    `polyline` (N, 2) is taken as a motion: only how it goes on from its first point matters.
    """
    way = even(polyline, knots)
    places = np.asarray(start, np.float64)
    return np.ascontiguousarray(places[:, None, :] + (way - way[0])[None], np.float32)


def single_file(polyline: npt.ArrayLike, start: npt.ArrayLike, *, gap: float = 0.8, knots: int = 129) -> Float32:
    """One after the other along a drawn way, as on a string: knots (D, knots, 2).

    Who stands nearest to the beginning of the way goes first and stops at its end, the others stay `gap` [m] apart
    behind her; each comes from her own place, and reaches the beginning of the way when it is her turn. The knots lie
    at even lengths of the *first* dancer's way, so all have to travel at the same times.
    """
    places = np.asarray(start, np.float64).reshape(-1, 2)
    way = even(polyline, max(knots, 257))
    at = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(way, axis=0).T))])
    order = np.argsort(np.hypot(*(places - way[0]).T), kind="stable")
    ways = np.empty((len(places), knots, 2), np.float32)
    approach = float(np.hypot(*(places[order[0]] - way[0]))) if len(order) else 0.0
    gone = np.linspace(0.0, approach + at[-1], knots)
    for rank, dancer in enumerate(order):
        turn = approach + rank * gap  # what the first has gone when this one reaches the beginning of the way
        share = np.clip(gone / max(turn, 1e-9), 0.0, 1.0)[:, None] if turn > 0.0 else np.ones((knots, 1))
        coming = places[dancer] + share * (way[0] - places[dancer])
        along = np.stack([np.interp(gone - turn, at, way[:, 0]), np.interp(gone - turn, at, way[:, 1])], axis=1)
        ways[dancer] = np.where((gone >= turn)[:, None], along, coming)
        if turn == 0.0:
            ways[dancer, 0] = places[dancer]
    return np.ascontiguousarray(ways)


def lengths(ways: npt.NDArray[np.floating]) -> Float64:
    """Length of each way (D, K, 2) [m], shape (D,)."""
    steps = np.diff(np.asarray(ways, np.float64), axis=1)
    return np.asarray(np.hypot(steps[..., 0], steps[..., 1]).sum(axis=1))


LEVELS = 6
"""1/2, 1/4 and 3/4, ... down to 1/64 of the time are looked at."""
SMOOTHING = 6
"""Passes of 1/4, 1/2, 1/4 after the ways have been parted."""
ROUNDS = 24
"""The thesis parts and smooths once; what the smoothing brings together again is parted anew, so many times at most."""
FREEDOM = 0.0
"""How freely the direction of a shift is drawn: 1 as in the thesis, any; 0 square to the dancers' relative motion, and
only the side is chance: ten dancers who all swap places through one point come by then, and do not with 1."""
PIECE = 200_000
"""Looks at a pair at a time that make one piece of work: about a millisecond."""


def divided(
    locomotion: Locomotion,
    clear: float,
    *,
    seed: int = 0,
    rounds: int = ROUNDS,
    smoothing: int = SMOOTHING,
    freedom: float = FREEDOM,
    half: tuple[float, float] | None = None,
) -> Locomotion:
    """The same journey with ways bent so that dancers keep `clear` [m] between their centres, as far as that goes.

    Of all rounds the ways with the fewest pairs that meet are kept (the earliest of equals). The result's ways are
    knots at even *times*, with the speeds of the journey in them. `half` keeps them on the stage [m]. Starts and goals
    stay. Same seed, same ways.
    """
    return at_once(
        dividing(locomotion, clear, seed=seed, rounds=rounds, smoothing=smoothing, freedom=freedom, half=half)
    )


def dividing(
    locomotion: Locomotion,
    clear: float,
    *,
    seed: int = 0,
    rounds: int = ROUNDS,
    smoothing: int = SMOOTHING,
    freedom: float = FREEDOM,
    half: tuple[float, float] | None = None,
) -> Pieces[Locomotion]:
    """`divided` in pieces."""
    begin, end = locomotion.begin, locomotion.end
    beats = np.linspace(begin, end, 2**LEVELS + 1)
    count = locomotion.count
    sample = np.zeros((len(beats), count, 2), np.float32)
    sample_ways(beats, locomotion.ways, locomotion.times, locomotion.soft, 0, count, sample)
    ways = np.ascontiguousarray(sample.transpose(1, 0, 2))
    offset = np.zeros_like(ways)
    low = -np.array(half if half is not None else (np.inf, np.inf), np.float32)
    best, fewest = ways.copy(), (yield from _meeting(ways, clear))
    for turn in range(rounds):
        if fewest == 0:
            break
        part_ways(ways, offset, clear, 1.15 + 0.05 * turn, freedom, seed + turn)
        yield
        for _ in range(smoothing):
            smooth_ways(offset)
        ways += offset
        if half is not None:
            np.clip(ways[:, 1:-1], low, -low, out=ways[:, 1:-1])
        meeting = yield from _meeting(ways, clear)
        if meeting < fewest:
            best, fewest = ways.copy(), meeting
    times = np.repeat(np.array([[begin, end]]), count, axis=0)
    return replace(locomotion, ways=best, times=times, soft=0.0)


def _meeting(ways: Float32, clear: float) -> Pieces[int]:
    """How many pairs come nearer than `clear` [m]."""
    count, times = ways.shape[:2]
    rows, meeting = max(1, PIECE // max(1, count * times)), 0
    step = np.zeros(count)
    longest_steps(ways, step)
    for first in range(0, count, rows):
        meeting += count_meetings(ways, step, first, min(first + rows, count), clear)
        yield
    return meeting
