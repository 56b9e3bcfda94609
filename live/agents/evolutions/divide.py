"""Divide and conquer: ways that meet are bent apart (T101, Schulz 2011, 4.3.2, after Perlin)."""

from dataclasses import replace

import numpy as np

from live.agents.evolutions.evolutions_kernels import part_ways, sample_ways, smooth_ways
from live.agents.evolutions.meetings_kernels import count_meetings, longest_steps
from live.agents.evolutions.pieces import Pieces, at_once
from live.agents.evolutions.trajectory import Float32, Locomotion

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
