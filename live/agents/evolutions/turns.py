"""Turns: where everybody faces on her way, as an orientation asks for it (T101-T103, T127)."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from live.agents.evolutions import orientation
from live.agents.evolutions.evolutions_kernels import profile
from live.agents.evolutions.orientation import Facing, Orientation
from live.agents.evolutions.segment_start import Departure, Journey
from live.agents.evolutions.trajectory import Float64, Locomotion


def turn_beats(facing: Orientation, departure: Departure) -> float:
    """Beats for each turn on the spot, which the way has to leave."""
    if facing.facing is not Facing.TANGENT:
        return 0.0
    return min(max(facing.turn_beats, 0.0), (departure.end - departure.begin) / 8.0)


def turned(
    journey: Journey, facing: Orientation, departure: Departure, after: npt.ArrayLike, *, closing: bool
) -> Journey:
    """The same with the headings asked for; `closing` says whether the last heading must be met exactly."""
    moved, before, last = journey.locomotion, departure.heading, np.asarray(after, np.float64)
    if facing.facing is Facing.LINEAR:
        turns = orientation.linear(moved.times, before, last)
    elif facing.facing is Facing.TANGENT:
        shares = _knot_shares(moved)
        turns = orientation.tangent(moved.ways, shares, moved.times, turn_beats(facing, departure), before, last)
    else:
        turns = _measure_turns(moved, facing, departure, last, closing)
    return replace(journey, locomotion=replace(moved, turns=turns))


def _knot_shares(moved: Locomotion) -> Float64:
    """The share of the time at which each knot of a way is passed, shape (K,)."""
    fine = np.linspace(0.0, 1.0, 513)
    gone = np.array([profile(float(t), moved.soft) for t in fine])
    return np.interp(np.linspace(0.0, 1.0, moved.ways.shape[1]), gone, fine)


def _measure_turns(
    moved: Locomotion, facing: Orientation, departure: Departure, last: Float64, closing: bool
) -> Float64:
    measures = max(1, round((departure.end - departure.begin) / departure.measure_beats))
    lines = departure.begin + departure.measure_beats * np.arange(measures + 1)
    if facing.facing is Facing.DECLARED:
        declared = facing.headings or (0.0,)
        series = np.array([declared[min(n, len(declared) - 1)] for n in range(measures)])
        headings = np.broadcast_to(series, (moved.count, measures))
        last, closing = headings[:, -1], False
    else:
        headings = orientation.travelled(moved.sampled(lines)[0], last)
    if facing.smooth:
        around = np.concatenate([departure.heading[:, None], headings, last[:, None]], axis=1)
        headings = orientation.smoothed(around)[:, 1:-1]
    if closing:
        headings = np.concatenate([headings[:, :-1], last[:, None]], axis=1)
    return orientation.by_measure(departure.begin, departure.measure_beats, departure.heading, headings)
