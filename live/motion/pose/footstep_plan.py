"""Footstep plans: how a measure's root correction is danced, with planned steps instead of a body pulled over its feet.

A correction moves the end of a measure. Every foot takes its part of it while it swings, in the order in which the feet
land, and the hips stay between the feet. So a foot that stands stays (T048, for translations), strides become longer,
shorter or go elsewhere, and no leg has to stretch more than half of what the feet are apart. A foot that stands all the
time takes a small step of its own on a beat, if the correction is large enough to need it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float32, Float64
from live.motion.editing.foot_correction import LEG_LENGTH
from live.motion.pose.footstep_kernels import initial_holds, limit_by_legs, limit_by_speed
from live.motion.pose.root_warp_kernels import DIRECTIONS
from live.motion.pose.warp_curve_kernels import KNOTS, SWING_BEGIN, WARP_RATE

SAMPLES_PER_KNOT: Final = 4
SAMPLES: Final = SAMPLES_PER_KNOT * (KNOTS - 1) + 1
"""Samples of a measure at which its contacts are read."""
MIN_SWING: Final = 6
"""A swing of fewer knots is too quick to lead a foot elsewhere."""
INSERTED_SWING: Final = 0.8
"""Length of an inserted step in beats; it lands on the beat."""
MAX_HIP_SPEED: Final = 2.6
"""Hips get faster than in the clip by no more than this [m per measure]."""
MAX_FOOT_SPEED: Final = 6.0
"""The same for a foot [m per measure]."""
MAX_HELD_SHIFT: Final = 0.4
"""Maximum shift of a standing foot from its place in the clip [m]; the lock releases it a little later."""
STANDING_MARGIN: Final = 0.08
"""Maximum correction [m] if no foot can be lifted: both are held against it."""
LENGTH_BUFFER: Final = 0.015
"""A leg is never stretched beyond its length minus this [m] (as in the pose kernels)."""
PELVIS_DROP: Final = 0.025
"""Allowed drop of the hips [m]: half of what the pose kernels allow."""
_PLACES: Final = np.linspace(0.0, 1.0, SAMPLES)
_ANGLES: Final = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
_WAYS: Final = np.ascontiguousarray(np.stack((np.sin(_ANGLES), np.cos(_ANGLES)), axis=1))


@dataclass(frozen=True, slots=True, eq=False)
class FootstepPlan:
    """When hips and feet of one measure take their part of a correction: share and rate at the knots."""

    root: Float64
    """Shape (KNOTS, 2), from 0 to 1."""
    feet: Float64
    """Left and right foot, from 0 to 1, or 0 for a foot that is never lifted, and their swings, shape (2, KNOTS, 5)."""
    steps: bool
    """Whether a foot is lifted at all."""


@dataclass(frozen=True, slots=True, eq=False)
class MeasurePlans:
    """Footstep plans of N measures, and how far each allows to correct."""

    root: Float64
    """Shape (N, KNOTS, 2)."""
    feet: Float64
    """Shape (N, 2, KNOTS, 5)."""
    margin: Float64
    """Farthest correction [m] in DIRECTIONS directions about the clip's axes, shape (N, DIRECTIONS)."""
    hold: Float64
    """Share applied before each foot that stands at the beginning is lifted, shape (N, 2)."""


def plan_measures(
    hip: Float32, ankle: Float32, contact: Bool, measures: Sequence[tuple[float, float]], *, beats: int, last: float
) -> MeasurePlans:
    """Plan the footsteps of N measures.

    `hip` and `ankle` (S, 2, 3) [m] of both legs and `contact` (S, 2) are those of all samples; each of `measures` is a
    first and a last sample. `beats` of a measure; `last`: see `plan_footsteps`.
    """
    roots, feet, margins, holds = [], [], [], []
    for begin, end in measures:
        # rounded within the clip, so that the same clip elsewhere in a library has the same plan
        base = math.floor(begin)
        at = base + np.floor(begin - base + _PLACES * (end - begin) + 0.5 + 1e-6).astype(np.int64)
        plan = plan_footsteps(contact[at], beats=beats, last=last)
        roots.append(plan.root)
        feet.append(plan.feet)
        margins.append(compute_reach_margin(hip[at], ankle[at], contact[at], plan))
        holds.append(initial_hold_shares(ankle[at], contact[at], plan))
    return MeasurePlans(np.stack(roots), np.stack(feet), np.stack(margins), np.stack(holds))


def plan_footsteps(contact: Bool, *, beats: int, last: float) -> FootstepPlan:
    """Return the plan of a measure with `contact` (SAMPLES, 2), evenly spaced from its beginning to its end.

    Nothing moves after `last` (share of the measure), where the blend lies (T050). A foot whose last swing has passed
    has its whole part; the swings before it share the way evenly in the order of their landings.
    """
    end = int(last * (KNOTS - 1) + 1e-9)
    swings = [swing for foot in range(2) for swing in _swings(contact[:, foot], foot, end)]
    for foot in range(2):
        if all(own != foot for own, _, _ in swings):
            swings += _inserted_swing(contact, swings, foot, beats, end)
    swings.sort(key=lambda swing: (swing[2], swing[0]))
    feet = np.zeros((2, KNOTS, 5))
    reached = np.zeros(2)
    final = {foot: index for index, (foot, _, _) in enumerate(swings)}
    for index, (foot, begin, stop) in enumerate(swings):
        goal = 1.0 if final[foot] == index else min(1.0, (index + 1) / max(len(swings) - 1, 1))
        feet[foot, :, WARP_RATE] += (goal - reached[foot]) * _hump(begin, stop)
        feet[foot, begin:stop, SWING_BEGIN:] = begin / (KNOTS - 1), stop / (KNOTS - 1), goal - reached[foot]
        reached[foot] = goal
    if not swings:
        rate = _hump(0, end)
        return FootstepPlan(_curve(rate), feet, steps=False)
    for foot in range(2):
        feet[foot, :, : WARP_RATE + 1] = _curve(feet[foot, :, WARP_RATE])
    return FootstepPlan(_curve(feet[..., WARP_RATE].sum(axis=0) / reached.sum()), feet, steps=True)


def _swings(stands: Bool, foot: int, end: int) -> list[tuple[int, int, int]]:
    """Return foot, first and last knot of the swings of one foot that are long enough and begin early enough."""
    found = []
    edges = np.flatnonzero(np.diff((~stands).astype(np.int8), prepend=0, append=0)).reshape(-1, 2)
    for begin, stop in edges.tolist():
        first, final = -(-begin // SAMPLES_PER_KNOT), min(stop, SAMPLES - 1) // SAMPLES_PER_KNOT
        cut = min(final, end)
        if cut - first >= max(MIN_SWING, (final - first) // 2):
            found.append((foot, first, cut))
    return found


def _inserted_swing(
    contact: Bool, swings: list[tuple[int, int, int]], foot: int, beats: int, end: int
) -> list[tuple[int, int, int]]:
    """Return a swing of `foot` that lands on a beat while the other foot stands, if the measure has room for one."""
    for beat in range(1, beats + 1):
        stop = int(beat / beats * (KNOTS - 1) + 1e-9)
        first = round(stop - INSERTED_SWING / beats * (KNOTS - 1))
        if stop > end or stop - first < MIN_SWING:
            continue
        part = slice(SAMPLES_PER_KNOT * first, SAMPLES_PER_KNOT * stop + 1)
        if contact[part].all() and all(begin >= stop or final <= first for _, begin, final in swings):
            return [(foot, first, stop)]
    return []


def _hump(begin: int, stop: int) -> Float64:
    """Return a rate at the knots that is 0 outside `begin` to `stop` and integrates to 1, (KNOTS,)."""
    u = np.clip((np.arange(KNOTS) - begin) / max(stop - begin, 1), 0.0, 1.0)
    rate = (u * (1.0 - u)) ** 2  # slow where a foot is still low
    return np.asarray(rate * ((KNOTS - 1) / rate.sum()))


def _curve(rate: Float64) -> Float64:
    """Return share and rate at the knots, (KNOTS, 2)."""
    share = np.concatenate(([0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1])) / (KNOTS - 1)))
    return np.ascontiguousarray(np.stack((share, rate), axis=1))


def compute_reach_margin(hip: Float32, ankle: Float32, contact: Bool, plan: FootstepPlan) -> Float64:
    """Return how far a measure may be corrected [m] in DIRECTIONS directions about the clip's heading, (DIRECTIONS,).

    `hip` and `ankle` (SAMPLES, 2, 3) [m] of both legs and `contact` (SAMPLES, 2). While a foot stands its leg must
    reach, wherever the plan has hips and foot; and neither hips nor feet may get much faster. A foot that slides in the
    clip itself is no constraint. Direction k has yaw 2 pi k / DIRECTIONS.
    """
    give = np.full(DIRECTIONS, np.inf)
    middle = np.ascontiguousarray(hip.mean(axis=1, keepdims=True), np.float32)
    limit_by_speed(middle, 0, plan.root, _WAYS, MAX_HIP_SPEED, SAMPLES_PER_KNOT, give)
    for foot in range(2):
        limit_by_speed(ankle, foot, plan.feet[foot], _WAYS, MAX_FOOT_SPEED, SAMPLES_PER_KNOT, give)
    longest = LEG_LENGTH - LENGTH_BUFFER
    planted = limit_by_legs(
        hip, ankle, contact, plan.root, plan.feet, _WAYS, longest, PELVIS_DROP, SAMPLES_PER_KNOT, give
    )
    if not plan.steps and planted:
        return np.asarray(np.minimum(give, STANDING_MARGIN))
    return np.asarray(np.maximum(give, 0.0))


def initial_hold_shares(ankle: Float32, contact: Bool, plan: FootstepPlan) -> Float64:
    """Return the share of the correction applied before each foot standing at the beginning is lifted, shape (2,)."""
    holds = np.empty(2)
    initial_holds(ankle, contact, plan.root, plan.feet, SAMPLES_PER_KNOT, holds)
    return holds
