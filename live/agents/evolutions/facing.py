"""Headings of dancers along their paths: linear, tangent, per measure, declared; smoothed (T101-T103, T126-T128)."""

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.evolution_kernels import profile
from live.agents.evolutions.trajectory import Locomotion
from live.base.arrays import Float64

if TYPE_CHECKING:
    from live.agents.evolutions.segment_start import PlannedMotion, SegmentStart


TURN_KNOTS = 5
"""Knots of a turn on the spot."""
MIN_PATH_LENGTH = 1e-3
"""A path shorter than this [m] has no direction."""


class Facing(StrEnum):
    """How the heading along the path is determined."""

    LINEAR = "linear"
    """Evenly from the first heading to the last, in the shorter direction (T102 a)."""
    TANGENT = "tangent"
    """Turn, travel facing along the path, turn again (T102 b)."""
    MEASURES = "measures"
    """One heading per measure: the travel direction, or the last heading where the dancer stands; smoothed (T126)."""
    DECLARED = "declared"
    """One heading per measure, as given in `Orientation.headings`."""


@dataclass(frozen=True, slots=True)
class Orientation:
    """How dancers face along their path."""

    facing: Facing = Facing.LINEAR
    headings: tuple[float, ...] = ()
    """For `Facing.DECLARED`: heading [rad] of each measure; the last one is held."""
    smooth: bool = True
    """For headings per measure: a quarter of the turn before its measure, half in it, a quarter after (T127)."""
    turn_beats: float = 1.0
    """For `Facing.TANGENT`: beats of each turn on the spot, at most an eighth of the time."""


def shortest_turn(before: npt.ArrayLike, after: npt.ArrayLike) -> Float64:
    """Return the turn [rad] in [-π, π) from one heading to another."""
    difference = np.asarray(after, np.float64) - np.asarray(before, np.float64)
    return np.asarray(difference - 2.0 * np.pi * np.floor((difference + np.pi) / (2.0 * np.pi)))


def unwrap(headings: npt.ArrayLike) -> Float64:
    """Return the headings (..., N) [rad] without jumps of more than half a turn along the last axis."""
    values = np.array(headings, np.float64)
    turns = shortest_turn(values[..., :-1], values[..., 1:])
    values[..., 1:] = values[..., :1] + np.cumsum(turns, axis=-1)
    return values


def smoothed(headings: npt.ArrayLike) -> Float64:
    """Return O'(n) = O(n-1)/4 + O(n)/2 + O(n+1)/4 along the last axis, unwrapped first (T127, Schulz 2011, 5.2).

    The first and last heading are repeated beyond the ends.
    """
    values = unwrap(headings)
    if values.shape[-1] < 2:
        return values
    padded = np.concatenate([values[..., :1], values, values[..., -1:]], axis=-1)
    return np.asarray(0.25 * padded[..., :-2] + 0.5 * padded[..., 1:-1] + 0.25 * padded[..., 2:])


def linear_turns(times: Float64, before: npt.ArrayLike, after: npt.ArrayLike) -> Float64:
    """Return knots (D, 2, 2) of an even turn in the shorter direction, over each dancer's `times` (D, 2) [beats]."""
    first = np.asarray(before, np.float64)
    heading = np.stack([first, first + shortest_turn(first, after)], axis=1)
    return np.ascontiguousarray(np.stack([times, heading], axis=-1))


def turns_by_measure(begin: float, measure_beats: float, before: npt.ArrayLike, headings: npt.ArrayLike) -> Float64:
    """Return knots (D, N + 1, 2) that reach heading n of `headings` (D, N) at the end of measure n after `begin`."""
    series = unwrap(np.concatenate([np.asarray(before, np.float64)[:, None], np.asarray(headings, np.float64)], axis=1))
    lines = begin + measure_beats * np.arange(series.shape[1])
    return np.ascontiguousarray(np.stack([np.broadcast_to(lines, series.shape), series], axis=-1))


def tangent_turns(
    ways: npt.NDArray[np.floating], shares: npt.ArrayLike, times: Float64, turn: float,
    before: npt.ArrayLike, after: npt.ArrayLike,
) -> Float64:  # fmt: skip
    """Return knots (D, H, 2): turn on the spot, face along the path, turn again (T102 b).

    `ways` (D, K, 2) are travelled within `times` (D, 2) [beats]; knot k is passed at the share `shares` (K,) of that
    time. The turns take `turn` [beats] before and after. A dancer without a path turns evenly from the first heading
    to the last. Where a path rests, the previous direction is kept.
    """
    knots = np.asarray(ways, np.float64)
    first, last = np.asarray(before, np.float64), np.asarray(after, np.float64)
    share = np.asarray(shares, np.float64)
    moving, direction = _directions(knots)
    middle = (share[:-1] + share[1:]) / 2.0
    travel = times[:, :1] + middle[None] * (times[:, 1:] - times[:, :1])
    ramp = np.linspace(0.0, 1.0, TURN_KNOTS)
    ease = ramp * ramp * (3.0 - 2.0 * ramp)
    start, end = times[:, :1], times[:, 1:]
    series = unwrap(np.concatenate([first[:, None], direction, last[:, None]], axis=1))
    opening = series[:, :1] + ease * (series[:, 1:2] - series[:, :1])
    closing = series[:, -2:-1] + ease * (series[:, -1:] - series[:, -2:-1])
    beats = np.concatenate([start - turn + ramp * turn, travel, end + ramp * turn], axis=1)
    facing = np.concatenate([opening, series[:, 1:-1], closing], axis=1)
    whole = (beats - beats[:, :1]) / np.maximum(beats[:, -1:] - beats[:, :1], 1e-9)
    still = first[:, None] + whole * shortest_turn(first, last)[:, None]
    facing = np.where(moving[:, None], facing, still)
    return np.ascontiguousarray(np.stack([beats, facing], axis=-1))


def travel_headings(places: npt.NDArray[np.floating], rest: npt.ArrayLike, min_distance: float = 0.1) -> Float64:
    """Return the heading of each measure (D, N) from places at the measure lines (N + 1, D, 2) (T126).

    It is the travel direction, or `rest` (D,), usually to the audience, if a dancer moves less than `min_distance` [m].
    """
    steps = np.diff(np.asarray(places, np.float64), axis=0).transpose(1, 0, 2)
    heading = np.arctan2(steps[..., 0], steps[..., 1])
    resting = np.broadcast_to(np.asarray(rest, np.float64)[:, None], heading.shape)
    return np.where(np.hypot(steps[..., 0], steps[..., 1]) < min_distance, resting, heading)


def final_direction(ways: npt.NDArray[np.floating], rest: npt.ArrayLike) -> Float64:
    """Return the direction of each path (D, K, 2) at its end, shape (D,) [rad]; `rest` (D,) where there is no path."""
    moving, direction = _directions(np.asarray(ways, np.float64))
    return np.where(moving, direction[:, -1], np.asarray(rest, np.float64))


def _directions(knots: Float64) -> tuple[npt.NDArray[np.bool_], Float64]:
    """Return which dancers move (D,) and the direction of each piece (D, K - 1); resting pieces repeat the last one."""
    steps = np.diff(knots, axis=1)
    length = np.hypot(steps[..., 0], steps[..., 1])
    direction = np.arctan2(steps[..., 0], steps[..., 1])
    goes = length > MIN_PATH_LENGTH / max(length.shape[1], 1)
    moving = goes.any(axis=1)
    piece = np.where(goes, np.arange(length.shape[1]), -1)
    piece = np.maximum.accumulate(piece, axis=1)
    piece = np.where(piece < 0, np.argmax(goes, axis=1)[:, None], piece)
    return moving, np.take_along_axis(direction, piece, axis=1)


def turn_beats(facing: Orientation, departure: "SegmentStart") -> float:
    """Return the beats of each turn on the spot, which the path has to leave free."""
    if facing.facing is not Facing.TANGENT:
        return 0.0
    return min(max(facing.turn_beats, 0.0), (departure.end - departure.begin) / 8.0)


def with_turns(
    journey: "PlannedMotion", facing: Orientation, departure: "SegmentStart", after: npt.ArrayLike, *, exact_end: bool
) -> "PlannedMotion":
    """Return the journey with the headings of `facing`; `exact_end`: the last heading must be met exactly."""
    moved, before, last = journey.locomotion, departure.heading, np.asarray(after, np.float64)
    if facing.facing is Facing.LINEAR:
        turns = linear_turns(moved.times, before, last)
    elif facing.facing is Facing.TANGENT:
        shares = _knot_shares(moved)
        turns = tangent_turns(moved.path_knots, shares, moved.times, turn_beats(facing, departure), before, last)
    else:
        turns = _measure_turns(moved, facing, departure, last, exact_end)
    return replace(journey, locomotion=replace(moved, turns=turns))


def _knot_shares(moved: Locomotion) -> Float64:
    """Return the share of the time at which each knot of a path is passed, shape (K,)."""
    fine = np.linspace(0.0, 1.0, 513)
    gone = np.array([profile(float(t), moved.ramp) for t in fine])
    return np.interp(np.linspace(0.0, 1.0, moved.path_knots.shape[1]), gone, fine)


def _measure_turns(
    moved: Locomotion, facing: Orientation, departure: "SegmentStart", last: Float64, exact_end: bool
) -> Float64:
    measures = max(1, round((departure.end - departure.begin) / departure.measure_beats))
    lines = departure.begin + departure.measure_beats * np.arange(measures + 1)
    if facing.facing is Facing.DECLARED:
        declared = facing.headings or (0.0,)
        series = np.array([declared[min(n, len(declared) - 1)] for n in range(measures)])
        headings = np.broadcast_to(series, (moved.count, measures))
        last, exact_end = headings[:, -1], False
    else:
        headings = travel_headings(moved.sample(lines)[0], last)
    if facing.smooth:
        around = np.concatenate([departure.heading[:, None], headings, last[:, None]], axis=1)
        headings = smoothed(around)[:, 1:-1]
    if exact_end:
        headings = np.concatenate([headings[:, :-1], last[:, None]], axis=1)
    return turns_by_measure(departure.begin, departure.measure_beats, departure.heading, headings)
