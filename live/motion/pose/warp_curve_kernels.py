"""Warp curve kernels: the share of a measure's correction applied so far, for the root and for each foot."""

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel

Float64 = npt.NDArray[np.float64]

KNOTS = 65
"""Knots of a warp curve over a measure, including both ends."""
WARP_SHARE, WARP_RATE, SWING_BEGIN, SWING_END, SWING_PART = range(5)
"""Columns of a warp curve: the share applied at a knot, and its slope there [1 per measure]. Those of a foot have three
more for the swing that begins at a knot or is going on there: where it begins and ends [share of the measure], and its
part of the correction."""


@inline_kernel
def curve_place(fraction: float, knots: int) -> tuple[int, float]:
    """Return the knot of a warp curve at or before `fraction` of the measure, and the part of the way to the next."""
    place = min(max(fraction, 0.0), 1.0) * (knots - 1)
    knot = min(int(place), knots - 2)
    return knot, place - knot


@inline_kernel
def share_between(curve: Float64, knot: int, part: float) -> float:
    """Return the share of the correction that a `curve` (KNOTS, C) has applied at a place, as of `curve_place`, C1.

    The rate is linear between knots, so the share is a parabola.
    """
    rate = curve[knot, WARP_RATE] + 0.5 * part * (curve[knot + 1, WARP_RATE] - curve[knot, WARP_RATE])
    share: float = curve[knot, WARP_SHARE] + part * rate / (curve.shape[0] - 1)
    return share


@kernel("f8(f8[:,::1], f8)")
def warp_share(warp_curve: Float64, fraction: float) -> float:
    """Return the share of the correction applied at `fraction` of the measure, 0 to 1; `warp_curve` (KNOTS, C)."""
    knot, part = curve_place(fraction, warp_curve.shape[0])
    return share_between(warp_curve, knot, part)


@kernel("f8(f8, f8, f8, f8)")
def warped_shift(share_now: float, share_then: float, shift: float, goal: float) -> float:
    """Return a dancer's shift [m] on the way from `shift` at `share_then` to `goal` at the end of the measure."""
    if share_then >= 1.0:
        return goal
    return shift + (share_now - share_then) / (1.0 - share_then) * (goal - shift)
