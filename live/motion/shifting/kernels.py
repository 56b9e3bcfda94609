"""How much of a measure's correction is in when part of the measure has passed, for kernels that place dancers."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

KNOTS = 65
"""Knots of a rise over a measure, the first at its beginning, the last at its end."""
SHARE, RATE = 0, 1
"""Columns of a rise: the share that is in at a knot, and how fast it grows there [1 per measure]."""


@kernel("f8(f8[:,::1], f8)")
def risen(rise: Float64, fraction: float) -> float:
    """Share of the correction that is in at `fraction` of the measure, 0 to 1, C1; `rise` (KNOTS, 2).

    Between knots the rate is a straight line, so the share is a parabola.
    """
    place = min(max(fraction, 0.0), 1.0) * (rise.shape[0] - 1)
    k = min(math.floor(place), rise.shape[0] - 2)
    u = place - k
    slope = rise[k, RATE] + 0.5 * u * (rise[k + 1, RATE] - rise[k, RATE])
    return rise[k, SHARE] + u * slope / (rise.shape[0] - 1)


@kernel("f8(f8, f8, f8, f8)")
def shifted(risen_now: float, risen_then: float, shift: float, goal: float) -> float:
    """How far a dancer is carried [m] who was by `shift` when `risen_then` was in and shall be by `goal` at the end."""
    if risen_then >= 1.0:
        return goal
    return shift + (risen_now - risen_then) / (1.0 - risen_then) * (goal - shift)


@kernel("void(f8[:,::1], f8[:,::1], f8[:,::1], f8[::1], i4[::1], f8[:,:,::1], f8)")
def re_aim_dancers(
    correction: Float64,
    aimed: Float64,
    goal: Float64,
    phase: Float64,
    node: Int32,
    rise: Float64,
    least_left: float,
) -> None:
    """Lead A dancers to `goal` (A, 2) [m] from `phase` (A,) on: `correction` (A, 3) and `aimed` (A, 3) are rewritten.

    `node` (A,) says whose row of `rise` (N, KNOTS, 2) counts; below 0: she is not led. Who has no more than
    `least_left` of her rise before her keeps what she has.
    """
    for n in range(correction.shape[0]):
        if node[n] < 0:
            continue
        share = risen(rise[node[n]], phase[n])
        if 1.0 - share <= least_left or share < aimed[n, 2]:
            continue
        for c in range(2):
            aimed[n, c] = shifted(share, aimed[n, 2], aimed[n, c], correction[n, c])
            correction[n, c] = goal[n, c]
        aimed[n, 2] = share
