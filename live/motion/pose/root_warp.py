"""Root warp per step: when in a measure the root may be moved, and how far, while feet keep their places.

The warp curve follows the clip's foot contacts (T048, for translations); the reach margin follows leg length.
"""

from typing import Final

import numpy as np

from live.base.arrays import Bool, Float32, Float64
from live.motion.pose.root_warp_kernels import DIRECTIONS, KNOTS
from live.motion.pose.warp_curve_kernels import hold_shares, reach_margin, warp_curve, warp_measures
from live.motion.skeleton import SKELETON

LEG_LENGTH: Final = sum(
    float(np.linalg.norm(SKELETON.offsets[SKELETON.index(name)])) for name in ("leftLowerLeg", "leftFoot")
)
"""Length of a leg from hip to ankle [m]."""


def measure_warps(
    hip: Float32, ankle: Float32, contact: Bool, first: Float64, end: Float64, *, last: float
) -> tuple[Float64, Float64, Float64]:
    """Return warp curve, reach margin and initial hold shares of N measures: (N, KNOTS, 2), (N, DIRECTIONS), (N, 2).

    `hip` and `ankle` (S, 2, 3) [m] of both legs and `contact` (S, 2) are those of all samples; the measures are between
    the samples `first` and `end` (N,). `last`: see `compute_warp_curve`.
    """
    count = len(first)
    out = np.empty((count, KNOTS, 2)), np.empty((count, DIRECTIONS)), np.empty((count, 2))
    warp_measures(
        np.ascontiguousarray(hip), np.ascontiguousarray(ankle), np.ascontiguousarray(contact), first, end, last,
        LEG_LENGTH, *out,
    )  # fmt: skip
    return out


def compute_warp_curve(contact: Bool, *, last: float) -> tuple[Float64, bool]:
    """Return the warp curve (KNOTS, 2) of a measure, and whether it follows the feet.

    `contact` (T, 2): whether each foot is on the floor, evenly spaced from the measure's beginning to its end. The
    share rises while at most one foot is in contact, and not after `last` (share of the measure), where the blend lies
    (T050). Several such stretches get weights that minimise the largest shift against a standing foot: a two-player
    game, solved by `minimax_weights`, whose costs are the shares of the warp during which a foot is held, and the speed
    in a stretch. If no foot is ever lifted, it rises throughout: an ease.
    """
    curve = np.empty((KNOTS, 2))
    follows = warp_curve(np.ascontiguousarray(contact), last, curve)
    return curve, bool(follows)


def compute_reach_margin(hip: Float64, ankle: Float64, contact: Bool, curve: Float64, *, follows_feet: bool) -> Float64:
    """Return the reach margin [m] in DIRECTIONS directions about the clip's heading, shape (DIRECTIONS,).

    `hip` and `ankle` (T, 2, 3) [m] of both legs and `contact` (T, 2), evenly spaced over the measure; `curve` (KNOTS,
    2). While a foot stands the body moves over it by the share applied meanwhile: the leg must reach, and no foot is
    held against more than MAX_HELD_SHIFT. A foot that slides in the clip itself is no constraint. Direction k has yaw 2
    pi k / DIRECTIONS.
    """
    margin = np.empty(DIRECTIONS)
    hip, ankle = np.ascontiguousarray(hip), np.ascontiguousarray(ankle)
    reach_margin(hip, ankle, np.ascontiguousarray(contact), curve, follows_feet, LEG_LENGTH, margin)
    return margin


def initial_hold_shares(ankle: Float64, contact: Bool, curve: Float64) -> Float64:
    """Return the share of the correction applied before each foot standing at the beginning is lifted, shape (2,)."""
    holds = np.empty(2)
    hold_shares(np.ascontiguousarray(ankle), np.ascontiguousarray(contact), curve, holds)
    return holds
