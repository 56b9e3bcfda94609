"""Root warp per step: when in a measure the root may be moved, and how far, while feet keep their places.

The warp curve follows the clip's foot contacts (T048, for translations); the reach margin follows leg length.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float64
from live.motion.pose.root_warp_kernels import DIRECTIONS, KNOTS, WARP_RATE, WARP_SHARE, minimax_weights
from live.motion.skeleton import SKELETON

SUBSTEPS: Final = 16
"""Evaluation points between two knots."""
MIN_FREE_SHARE: Final = 0.04
"""Minimum share of the measure with a foot in the air; below it the warp is spread over the whole measure."""
MAX_HELD_SHIFT: Final = 0.15
"""Maximum shift against a held foot while it stands [m]; the lock releases at 0.2 m."""
MAX_WARP_RATE: Final = 1.3
"""Maximum warp speed [m per measure]."""
ROUNDS: Final = 256
"""Rounds of the minimax weighting of the stretches."""


def measure_warps(
    hip: Float64, ankle: Float64, contact: Bool, measures: Sequence[tuple[float, float]], *, last: float
) -> tuple[Float64, Float64, Float64]:
    """Return warp curve, reach margin and initial hold shares of N measures: (N, KNOTS, 2), (N, DIRECTIONS), (N, 2).

    `hip` and `ankle` (S, 2, 3) [m] of both legs and `contact` (S, 2) are those of all samples; each of `measures` is a
    first and a last sample. `last`: see `compute_warp_curve`.
    """
    curves, margins, holds = [], [], []
    for begin, end in measures:
        at = np.linspace(begin, end, 4 * (KNOTS - 1) + 1).round().astype(np.int64)
        stands, feet = contact[at], ankle[at]
        curve, follows_feet = compute_warp_curve(stands, last=last)
        curves.append(curve)
        margins.append(compute_reach_margin(hip[at], feet, stands, curve, follows_feet=follows_feet))
        holds.append(initial_hold_shares(feet, stands, curve))
    return np.stack(curves), np.stack(margins), np.stack(holds)


def compute_warp_curve(contact: Bool, *, last: float) -> tuple[Float64, bool]:
    """Return the warp curve (KNOTS, 2) of a measure, and whether it follows the feet.

    `contact` (T, 2): whether each foot is on the floor, evenly spaced from the measure's beginning to its end. The
    share rises while at most one foot is in contact, and not after `last` (share of the measure), where the blend lies
    (T050). Several such stretches get weights that minimise the largest shift against a standing foot. If no foot is
    ever lifted, it rises throughout: an ease.
    """
    fine = np.linspace(0.0, 1.0, SUBSTEPS * (KNOTS - 1) + 1)
    stands = contact[np.minimum((fine * (len(contact) - 1)).round().astype(np.int64), len(contact) - 1)]
    free = ~stands.all(axis=1) & (fine < last)
    follows = bool(free.mean() >= MIN_FREE_SHARE)
    if not follows:
        free = fine < last
    humps = _stretch_rates(free)
    knots = _rates_at_knots(_minimax_weights(humps, stands) @ humps)
    share = np.concatenate(([0.0], np.cumsum(0.5 * (knots[1:] + knots[:-1])) / (KNOTS - 1)))
    return np.ascontiguousarray(np.stack((share, knots), axis=1) / share[-1]), follows


def stances(contact: Bool) -> list[tuple[int, int, int]]:
    """Return foot, first sample and end (exclusive) of all contact intervals from `contact` (T, 2)."""
    found = []
    for foot in range(2):
        edges = np.flatnonzero(np.diff(contact[:, foot].astype(np.int8), prepend=0, append=0))
        found += [(foot, int(begin), int(end)) for begin, end in zip(edges[::2], edges[1::2], strict=True)]
    return found


def _stretch_rates(free: Bool) -> Float64:
    """Return for each free stretch a rate that begins and ends at 0, shape (K, F); each sums to 1."""
    edges = np.flatnonzero(np.diff(free.astype(np.int8), prepend=0, append=0)).reshape(-1, 2)
    humps = np.zeros((len(edges), len(free)))
    for hump, (begin, end) in zip(humps, edges, strict=True):
        u = (np.arange(begin, end) + 0.5 - begin) / (end - begin)
        hump[begin:end] = u * (1.0 - u)
    return np.asarray(humps / humps.sum(axis=1, keepdims=True))


def _minimax_weights(humps: Float64, stands: Bool) -> Float64:
    """Return weights (K,) of the stretches that minimise the largest cost.

    Costs are the shares of the warp during which a foot is held, and the speed in a stretch. This minimax problem is a
    two-player game, solved by `minimax_weights`.
    """
    lengths = (humps > 0.0).mean(axis=1)
    held = [humps[:, begin:end].sum(axis=1) / MAX_HELD_SHIFT for _, begin, end in stances(stands)]
    costs = np.stack([*held, *np.diag(1.5 / (lengths * MAX_WARP_RATE))])
    weights: Float64 = lengths / lengths.sum()
    minimax_weights(costs, weights, ROUNDS)
    return weights


def _rates_at_knots(rate: Float64) -> Float64:
    """Return rates at the knots from those at fine points: means about each knot, 0 at both ends."""
    passed = np.concatenate(([0.0], np.cumsum(rate)))
    middle = SUBSTEPS * np.arange(1, KNOTS - 1)
    knots = np.zeros(KNOTS)
    knots[1:-1] = (passed[middle + SUBSTEPS // 2 + 1] - passed[middle - SUBSTEPS // 2]) / (SUBSTEPS + 1)
    return knots


LEG_LENGTH: Final = sum(
    float(np.linalg.norm(SKELETON.offsets[SKELETON.index(name)])) for name in ("leftLowerLeg", "leftFoot")
)
"""Length of a leg from hip to ankle [m]."""
LENGTH_BUFFER: Final = 0.015
"""A leg is never stretched beyond its length minus this [m] (as in the pose kernels)."""
PELVIS_DROP: Final = 0.01
"""Allowed drop of the hips [m]: half of what the pose kernels allow."""
SLIDE_DISTANCE: Final = 0.2
"""A foot that moves this far [m] during annotated contact is not planted: the foot lock releases it."""
STANDING_MARGIN: Final = 0.08
"""Maximum warp [m] if no foot is ever lifted, because the feet never step to a new place."""


def compute_reach_margin(hip: Float64, ankle: Float64, contact: Bool, curve: Float64, *, follows_feet: bool) -> Float64:
    """Return the reach margin [m] in DIRECTIONS directions about the clip's heading, shape (DIRECTIONS,).

    `hip` and `ankle` (T, 2, 3) [m] of both legs and `contact` (T, 2), evenly spaced over the measure; `curve` (KNOTS,
    2). While a foot stands the body moves over it by the share applied meanwhile: the leg must reach, and no foot is
    held against more than MAX_HELD_SHIFT. A foot that slides in the clip itself is no constraint. Direction k has yaw 2
    pi k / DIRECTIONS.
    """
    planted = [stance for stance in stances(contact) if not _slides(ankle, *stance)]
    follows_feet |= len(planted) < len(stances(contact))
    angle = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    ways = np.stack((np.sin(angle), np.cos(angle)), axis=1)
    places = np.linspace(0.0, 1.0, len(contact))
    share = np.interp(places, np.linspace(0.0, 1.0, KNOTS), curve[:, WARP_SHARE])
    give = np.full(DIRECTIONS, MAX_WARP_RATE / curve[:, WARP_RATE].max() if follows_feet else STANDING_MARGIN)
    for foot, begin, end in planted:
        risen = share[begin:end] - share[begin]
        if risen[-1] <= 1e-3:
            continue
        leg = ankle[begin:end, foot] - hip[begin:end, foot]
        longest = np.maximum(LEG_LENGTH - LENGTH_BUFFER, np.linalg.norm(leg, axis=1))
        level = longest**2 - np.minimum(leg[:, 1] + PELVIS_DROP, 0.0) ** 2  # squared reach on the floor
        flat = leg[:, (0, 2)]
        along = flat @ ways.T  # the body moves ahead: the foot first gets nearer by this, then falls behind
        spare = np.maximum(level - np.sum(flat * flat, axis=1), 0.0)[:, None]
        far = along + np.sqrt(along * along + spare)
        moves = risen > 1e-3
        give = np.minimum(give, np.min(far[moves] / risen[moves, None], axis=0))
        give = np.minimum(give, MAX_HELD_SHIFT / risen[-1])
    return np.asarray(np.maximum(give, 0.0))


def initial_hold_shares(ankle: Float64, contact: Bool, curve: Float64) -> Float64:
    """Return the share of the correction applied before each foot standing at the beginning is lifted, shape (2,)."""
    share = np.interp(np.linspace(0.0, 1.0, len(contact)), np.linspace(0.0, 1.0, KNOTS), curve[:, WARP_SHARE])
    holds = np.zeros(2)
    for foot, begin, end in stances(contact):
        if begin == 0 and not _slides(ankle, foot, begin, end):
            holds[foot] = share[end - 1]
    return holds


def _slides(ankle: Float64, foot: int, begin: int, end: int) -> bool:
    """Whether the clip itself moves that foot, from `ankle` (T, 2, 3), farther than the foot lock would hold it."""
    way = ankle[begin:end, foot][:, (0, 2)]
    return bool(np.ptp(way, axis=0).max() > SLIDE_DISTANCE)
