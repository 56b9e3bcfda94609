"""Warp curve kernels: the share of a measure's correction applied so far, for the root and for each foot."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float64 = npt.NDArray[np.float64]

KNOTS = 65
"""Knots of a warp curve over a measure, including both ends."""
WARP_SHARE, WARP_RATE, SWING_BEGIN, SWING_END, SWING_PART = range(5)
"""Columns of a warp curve: the share applied at a knot, and its slope there [1 per measure]. Those of a foot have three
more for the swing that begins at a knot or is going on there: where it begins and ends [share of the measure], and its
part of the correction."""


@kernel("f8(f8[:,::1], f8)")
def warp_share(warp_curve: Float64, fraction: float) -> float:
    """Return the share of the correction applied at `fraction` of the measure, 0 to 1, C1; `warp_curve` (KNOTS, 2).

    The rate is linear between knots, so the share is a parabola.
    """
    place = min(max(fraction, 0.0), 1.0) * (warp_curve.shape[0] - 1)
    k = min(math.floor(place), warp_curve.shape[0] - 2)
    u = place - k
    slope = warp_curve[k, WARP_RATE] + 0.5 * u * (warp_curve[k + 1, WARP_RATE] - warp_curve[k, WARP_RATE])
    share: float = warp_curve[k, WARP_SHARE] + u * slope / (warp_curve.shape[0] - 1)
    return share


@kernel("f8(f8, f8, f8, f8)")
def warped_shift(share_now: float, share_then: float, shift: float, goal: float) -> float:
    """Return a dancer's shift [m] on the way from `shift` at `share_then` to `goal` at the end of the measure."""
    if share_then >= 1.0:
        return goal
    return shift + (share_now - share_then) / (1.0 - share_then) * (goal - shift)
