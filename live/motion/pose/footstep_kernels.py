"""Kernels of footstep plans: how far a plan has moved a foot, how far a measure may be corrected in each direction, and
what feet are held against."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.pose.warp_curve_kernels import (
    SWING_BEGIN,
    SWING_END,
    SWING_PART,
    WARP_RATE,
    WARP_SHARE,
    curve_place,
    share_between,
)

Bool = npt.NDArray[np.bool_]
Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]

SLIDE_DISTANCE = 0.2
"""A foot that moves this far [m] during annotated contact is not planted in the clip itself."""
MIN_AHEAD = 1e-3
"""A foot that is ahead of the hips by a smaller share of the correction does not limit it."""
STEP_HEIGHT = 0.09
"""Height of a step of a footstep plan [m] ..."""
STEP_LENGTH = 0.08
"""... which has half of it if it moves the foot so far [m] ..."""
STEP_TIME = 0.2
"""... and less if it is shorter than this share of the measure."""
AIM_X, AIM_Z, AIM_SHARE, SETTLED, SETTLED_X, SETTLED_Z = range(6)
"""Columns of the aim of a foot: its shift [m] and share when the measure's correction last changed; 1 if that came too
late for the foot, which then keeps its goal [m]."""


@inline_kernel
def shift_between(
    curve: Float64, knot: int, part: float, fraction: float, aim: Float64, goal_x: float, goal_z: float
) -> tuple[float, float, float]:
    """Return the same as `foot_shift` at a place as of `curve_place`."""
    left = 1.0 - aim[AIM_SHARE]
    x, z, lift = aim[AIM_X], aim[AIM_Z], 0.0
    if left >= 1e-6:
        if aim[SETTLED] > 0.0:
            goal_x, goal_z = aim[SETTLED_X], aim[SETTLED_Z]
        way_x, way_z = (goal_x - x) / left, (goal_z - z) / left
        passed = max(share_between(curve, knot, part) - aim[AIM_SHARE], 0.0)
        begin, size = curve[knot, SWING_BEGIN], curve[knot, SWING_END] - curve[knot, SWING_BEGIN]
        if size > 0.0:
            u = min(max((fraction - begin) / size, 0.0), 1.0)
            moved = math.sqrt(way_x * way_x + way_z * way_z) * curve[knot, SWING_PART]
            high = STEP_HEIGHT * min(1.0, size / STEP_TIME) * moved / (moved + STEP_LENGTH)
            lift = high * 16.0 * (u * (1.0 - u)) ** 2
        x, z = x + passed * way_x, z + passed * way_z
    return x, z, lift


@kernel("UniTuple(f8,3)(f8[:,::1], f8, f8[::1], f8, f8)")
def foot_shift(
    curve: Float64, fraction: float, aim: Float64, goal_x: float, goal_z: float
) -> tuple[float, float, float]:
    """Return how far the footstep plan has moved a foot at `fraction` of the measure, x, z [m], and how high it lifts
    the foot [m]. `curve` (KNOTS, 5) of the foot, `aim` (6,), `goal_x` and `goal_z`: the measure's correction."""
    knot, part = curve_place(fraction, curve.shape[0])
    return shift_between(curve, knot, part, fraction, aim, goal_x, goal_z)


@kernel("f8(f8[:,::1], i8, i8)")
def share_at(curve: Float64, sample: int, per_knot: int) -> float:
    """Return the share of a `curve` (KNOTS, C) at a sample of the measure, `per_knot` samples between two knots."""
    knot = min(sample // per_knot, curve.shape[0] - 2)
    part = sample / per_knot - knot
    share: float = curve[knot, WARP_SHARE] + part * (curve[knot + 1, WARP_SHARE] - curve[knot, WARP_SHARE])
    return share


@kernel("i8(b1[:,::1], i8, i8)")
def stance_end(contact: Bool, foot: int, begin: int) -> int:
    """Return the sample after the stance of `foot` that begins at `begin`."""
    end = begin
    while end < contact.shape[0] and contact[end, foot]:
        end += 1
    return end


@kernel("b1(f4[:,:,::1], i8, i8, i8)")
def foot_slides(ankle: Float32, foot: int, begin: int, end: int) -> bool:
    """Whether the clip itself moves a foot from `begin` to `end`, by `ankle` (T, 2, 3) [m], farther than a planted
    one."""
    for axis in (0, 2):
        low = high = ankle[begin, foot, axis]
        for t in range(begin + 1, end):
            low, high = min(low, ankle[t, foot, axis]), max(high, ankle[t, foot, axis])
        if high - low > SLIDE_DISTANCE:
            return True
    return False


@kernel("void(f4[:,:,::1], i8, f8[:,::1], f8[:,::1], f8, i8, f8[::1])")
def limit_by_speed(
    place: Float32, joint: int, curve: Float64, ways: Float64, most: float, per_knot: int, give: Float64
) -> None:
    """Lower `give` (D,) [m] so that a joint led by `curve` (KNOTS, C) along `ways` (D, 2) gets faster than in the clip
    by no more than `most` [m per measure]. `place` (T, J, 3) [m] of the joints, of which `joint` counts."""
    last = curve.shape[0] - 1
    for k in range(last + 1):
        rate = curve[k, WARP_RATE]
        if rate <= 1e-3:
            continue
        before, after = max(k - 1, 0), min(k + 1, last)
        scale = last / (after - before)
        x = (place[after * per_knot, joint, 0] - place[before * per_knot, joint, 0]) * scale
        z = (place[after * per_knot, joint, 2] - place[before * per_knot, joint, 2]) * scale
        own = math.sqrt(x * x + z * z)
        room = (own + most) * (own + most) - own * own
        for d in range(ways.shape[0]):
            along = x * ways[d, 0] + z * ways[d, 1]
            give[d] = min(give[d], (math.sqrt(along * along + room) - along) / rate)


@kernel("b1(f4[:,:,::1], f4[:,:,::1], b1[:,::1], f8[:,::1], f8[:,:,::1], f8[:,::1], f8, f8, i8, f8[::1])")
def limit_by_legs(
    hip: Float32, ankle: Float32, contact: Bool, root: Float64, feet: Float64, ways: Float64, leg: float, drop: float,
    per_knot: int, give: Float64,
) -> bool:  # fmt: skip
    """Lower `give` (D,) [m] so that the legs of all stances reach; return whether all of them are planted.

    `hip` and `ankle` (T, 2, 3) [m], `contact` (T, 2); curves `root` (KNOTS, C) and `feet` (2, KNOTS, C); a leg is no
    longer than `leg` [m], or than in the clip, with the hips sunk by `drop` [m].
    """
    planted = True
    for foot in range(2):
        t = 0
        while t < contact.shape[0]:
            end = stance_end(contact, foot, t)
            if end == t:
                t += 1
                continue
            if foot_slides(ankle, foot, t, end):
                planted, t = False, end
                continue
            for s in range(t, end):
                ahead = share_at(feet[foot], s, per_knot) - share_at(root, s, per_knot)
                if abs(ahead) <= MIN_AHEAD:
                    continue
                x, y = ankle[s, foot, 0] - hip[s, foot, 0], ankle[s, foot, 1] - hip[s, foot, 1]
                z = ankle[s, foot, 2] - hip[s, foot, 2]
                flat, height = x * x + z * z, min(y + drop, 0.0)
                longest = max(leg, math.sqrt(flat + y * y))
                spare = max(longest * longest - height * height - flat, 0.0)
                for d in range(ways.shape[0]):
                    along = x * ways[d, 0] + z * ways[d, 1]
                    along = along if ahead > 0.0 else -along
                    give[d] = min(give[d], (math.sqrt(along * along + spare) - along) / abs(ahead))
            t = end
    return planted


@kernel("void(f4[:,:,::1], b1[:,::1], f8[:,::1], f8[:,:,::1], i8, f8[::1])")
def initial_holds(ankle: Float32, contact: Bool, root: Float64, feet: Float64, per_knot: int, out: Float64) -> None:
    """Write the share of the correction that is applied before each foot standing at the beginning is led, (2,)."""
    for foot in range(2):
        out[foot] = 0.0
        end = stance_end(contact, foot, 0)
        if end == 0 or foot_slides(ankle, foot, 0, end):
            continue
        for s in range(end):
            if share_at(feet[foot], s, per_knot) < 1e-6:
                out[foot] = max(out[foot], share_at(root, s, per_knot))
