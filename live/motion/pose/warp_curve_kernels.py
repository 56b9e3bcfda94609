"""Kernels that measure a clip's feet: when a root warp is applied in each measure, and how far it may go."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.motion.pose.root_warp_kernels import DIRECTIONS, KNOTS, WARP_RATE, WARP_SHARE, minimax_weights

Bool = npt.NDArray[np.bool_]
Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

SUBSTEPS = 16
"""Evaluation points between two knots."""
MIN_FREE_SHARE = 0.04
"""Minimum share of the measure with a foot in the air; below it the warp is spread over the whole measure."""
MAX_HELD_SHIFT = 0.15
"""Maximum shift against a held foot while it stands [m]; the lock releases at 0.2 m."""
MAX_WARP_RATE = 1.3
"""Maximum warp speed [m per measure]."""
ROUNDS = 256
"""Rounds of the minimax weighting of the stretches."""
LENGTH_BUFFER = 0.015
"""A leg is never stretched beyond its length minus this [m] (as in the pose kernels)."""
PELVIS_DROP = 0.01
"""Allowed drop of the hips [m]: half of what the pose kernels allow."""
SLIDE_DISTANCE = 0.2
"""A foot that moves this far [m] during annotated contact is not planted: the foot lock releases it."""
STANDING_MARGIN = 0.08
"""Maximum warp [m] if no foot is ever lifted, because the feet never step to a new place."""
_LEAST_SHARE = 1e-3
"""A smaller share of the warp while a foot stands counts as none."""


@kernel("i8(b1[::1],i8[:,::1])")
def find_runs(state: Bool, out: Int64) -> int:
    """Write first index and end (exclusive) of each run of True in `state` (T,) to out (T, 2); returns their number."""
    count = 0
    for t in range(state.shape[0]):
        if state[t] and (t == 0 or not state[t - 1]):
            out[count, 0] = t
            count += 1
        if state[t]:
            out[count - 1, 1] = t + 1
    return count


@kernel("b1(b1[:,::1],f8,f8[:,::1])")
def warp_curve(  # noqa: C901
    contact: Bool, last: float, curve: Float64
) -> bool:
    """Write the warp curve (KNOTS, 2) of a measure with `contact` (T, 2), see `root_warp.compute_warp_curve`.

    Returns whether it follows the feet.
    """
    fine = SUBSTEPS * (KNOTS - 1) + 1
    stands, free, runs = np.empty((2, fine), np.bool_), np.empty(fine, np.bool_), np.empty((fine, 2), np.int64)
    held_runs = np.empty((fine, 2), np.int64)
    number = 0
    for f in range(fine):
        at = min(int(np.rint(f / (fine - 1) * (contact.shape[0] - 1))), contact.shape[0] - 1)
        stands[0, f], stands[1, f] = contact[at, 0], contact[at, 1]
        free[f] = not (stands[0, f] and stands[1, f]) and f / (fine - 1) < last
        number += free[f]
    follows = number / fine >= MIN_FREE_SHARE
    if not follows:
        for f in range(fine):
            free[f] = f / (fine - 1) < last
    stretches = find_runs(free, runs)
    hump = np.zeros(fine)
    weights = np.empty(stretches)
    for k in range(stretches):
        begin, end = runs[k, 0], runs[k, 1]
        total = 0.0
        for f in range(begin, end):
            u = (f + 0.5 - begin) / (end - begin)
            hump[f] = u * (1.0 - u)
            total += hump[f]
        for f in range(begin, end):
            hump[f] /= total
        weights[k] = (end - begin) / fine
    costs = np.zeros((2 * fine + stretches, stretches))
    row = 0
    for foot in range(2):
        for run in range(find_runs(stands[foot], held_runs)):
            for k in range(stretches):
                for f in range(max(held_runs[run, 0], runs[k, 0]), min(held_runs[run, 1], runs[k, 1])):
                    costs[row, k] += hump[f]
                costs[row, k] /= MAX_HELD_SHIFT
            row += 1
    for k in range(stretches):
        costs[row + k, k] = 1.5 / (weights[k] * MAX_WARP_RATE)
    weights /= weights.sum()
    minimax_weights(costs[: row + stretches], weights, ROUNDS)
    passed = np.zeros(fine + 1)
    k = 0
    for f in range(fine):
        while k < stretches - 1 and f >= runs[k, 1]:
            k += 1
        passed[f + 1] = passed[f] + weights[k] * hump[f]
    curve[0, WARP_SHARE] = curve[0, WARP_RATE] = curve[KNOTS - 1, WARP_RATE] = 0.0
    for n in range(1, KNOTS - 1):  # means about each knot
        middle = SUBSTEPS * n
        curve[n, WARP_RATE] = (passed[middle + SUBSTEPS // 2 + 1] - passed[middle - SUBSTEPS // 2]) / (SUBSTEPS + 1)
    for n in range(1, KNOTS):
        curve[n, WARP_SHARE] = curve[n - 1, WARP_SHARE] + 0.5 * (curve[n, WARP_RATE] + curve[n - 1, WARP_RATE]) / (
            KNOTS - 1
        )
    whole = curve[KNOTS - 1, WARP_SHARE]
    for n in range(KNOTS):
        curve[n, 0] /= whole
        curve[n, 1] /= whole
    return follows


@kernel("f8(f8[:,::1],f8)")
def share_at(curve: Float64, fraction: float) -> float:
    """Return the share of the warp applied at `fraction` of the measure, linear between the knots."""
    k = min(int(fraction * (KNOTS - 1)), KNOTS - 2)
    low, high = curve[k, WARP_SHARE], curve[k + 1, WARP_SHARE]
    return float((high - low) * (KNOTS - 1) * (fraction - k / (KNOTS - 1)) + low)


@kernel("b1(f8[:,:,::1],i8,i8,i8)")
def foot_slides(ankle: Float64, foot: int, begin: int, end: int) -> bool:
    """Whether the clip itself moves that foot, from `ankle` (T, 2, 3), farther than the foot lock would hold it."""
    for axis in (0, 2):
        low = high = ankle[begin, foot, axis]
        for t in range(begin, end):
            low, high = min(low, ankle[t, foot, axis]), max(high, ankle[t, foot, axis])
        if high - low > SLIDE_DISTANCE:
            return True
    return False


@kernel("void(f8[:,:,::1],f8[:,:,::1],b1[:,::1],f8[:,::1],b1,f8,f8[::1])")
def reach_margin(  # noqa: C901
    hip: Float64, ankle: Float64, contact: Bool, curve: Float64, follows_feet: bool, leg_length: float, margin: Float64
) -> None:
    """Write the reach margin (DIRECTIONS,) [m], see `root_warp.compute_reach_margin`; `leg_length` [m]."""
    count = contact.shape[0]
    share = np.empty(count)
    for t in range(count):
        share[t] = share_at(curve, t / max(count - 1, 1))
    runs, state = np.empty((count, 2), np.int64), np.empty(count, np.bool_)
    follows = follows_feet
    margin[:] = math.inf
    ways = np.empty((DIRECTIONS, 2))
    for d in range(DIRECTIONS):
        ways[d, 0], ways[d, 1] = math.sin(2.0 * math.pi * d / DIRECTIONS), math.cos(2.0 * math.pi * d / DIRECTIONS)
    for foot in range(2):
        state[:] = contact[:, foot]
        for run in range(find_runs(state, runs)):
            begin, end = runs[run, 0], runs[run, 1]
            if foot_slides(ankle, foot, begin, end):
                follows = True
                continue
            last = share[end - 1] - share[begin]
            if last <= _LEAST_SHARE:
                continue
            for d in range(DIRECTIONS):
                margin[d] = min(margin[d], MAX_HELD_SHIFT / last)
            for t in range(begin, end):
                risen = share[t] - share[begin]
                if risen <= _LEAST_SHARE:
                    continue
                x, y = ankle[t, foot, 0] - hip[t, foot, 0], ankle[t, foot, 1] - hip[t, foot, 1]
                z = ankle[t, foot, 2] - hip[t, foot, 2]
                longest = max(leg_length - LENGTH_BUFFER, math.sqrt(x * x + y * y + z * z))
                level = longest * longest - min(y + PELVIS_DROP, 0.0) ** 2  # squared reach on the floor
                spare = max(level - (x * x + z * z), 0.0)
                for d in range(DIRECTIONS):
                    # the body moves ahead: the foot first gets nearer by this, then falls behind
                    along = x * ways[d, 0] + z * ways[d, 1]
                    margin[d] = min(margin[d], (along + math.sqrt(along * along + spare)) / risen)
    highest = 0.0
    for n in range(KNOTS):
        highest = max(highest, curve[n, WARP_RATE])
    most = MAX_WARP_RATE / highest if follows else STANDING_MARGIN
    for d in range(DIRECTIONS):
        margin[d] = max(0.0, min(margin[d], most))


@kernel("void(f8[:,:,::1],b1[:,::1],f8[:,::1],f8[::1])")
def hold_shares(ankle: Float64, contact: Bool, curve: Float64, out: Float64) -> None:
    """Write the share applied before each foot is first lifted (2,), see `root_warp.initial_hold_shares`."""
    count = contact.shape[0]
    for foot in range(2):
        end = 0
        while end < count and contact[end, foot]:
            end += 1
        out[foot] = 0.0
        if end > 0 and not foot_slides(ankle, foot, 0, end):
            out[foot] = share_at(curve, (end - 1) / max(count - 1, 1))


@kernel("void(f4[:,:,::1],f4[:,:,::1],b1[:,::1],f8[::1],f8[::1],f8,f8,f8[:,:,::1],f8[:,::1],f8[:,::1])")
def warp_measures(
    hip: Float32, ankle: Float32, contact: Bool, first: Float64, end: Float64, last: float, leg_length: float,
    curve: Float64, margin: Float64, hold: Float64,
) -> None:  # fmt: skip
    """Write curve, margin and hold shares of N measures from samples first (N,) to end (N,), see
    `root_warp.measure_warps`."""
    count = 4 * (KNOTS - 1) + 1
    own_hip, own_ankle = np.empty((count, 2, 3)), np.empty((count, 2, 3))
    stands = np.empty((count, 2), np.bool_)
    for n in range(first.shape[0]):
        step = (end[n] - first[n]) / (count - 1)
        for t in range(count):
            at = int(np.rint(first[n] + t * step if t < count - 1 else end[n]))
            stands[t] = contact[at]
            for foot in range(2):
                for c in range(3):
                    own_hip[t, foot, c], own_ankle[t, foot, c] = hip[at, foot, c], ankle[at, foot, c]
        follows = warp_curve(stands, last, curve[n])
        reach_margin(own_hip, own_ankle, stands, curve[n], follows, leg_length, margin[n])
        hold_shares(own_ankle, stands, curve[n], hold[n])
