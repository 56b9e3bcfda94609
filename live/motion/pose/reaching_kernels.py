"""One arm that reaches for somebody else's palm: she whose palm it is, is not moved (H014)."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel, part
from live.motion.pose.arms_kernels import (
    FORWARD,
    GOAL,
    HAND,
    LOWER,
    PALM_ROW,
    REACH,
    ROWS,
    SHARE,
    UPPER,
    Rotation,
    Vector,
    after,
    bend_arm,
    gather_arm,
    scatter_arm,
    turn_by,
    turn_from,
)
from live.motion.pose.sample_kernels import BLOCK

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

SOFT: Any = np.float32(0.03)
"""An arm nearer to straight than this [m] stretches ever less: its elbow does not snap; at all its reach the palm is
then 0.37 of it off."""
ASIDE: Any = np.float32(0.4)
"""Arms go from place to place past the front, so much to their own side and as much down of where the chest faces."""
_ZERO: Any = np.float32(0.0)
_ONE: Any = np.float32(1.0)
_TWO: Any = np.float32(2.0)
_TINY: Any = np.float32(1e-12)
_LEAST: Any = np.float32(1e-6)


@part
def _unit(x: float, y: float, z: float) -> Vector:
    """The vector at length 1."""
    scale = _ONE / math.sqrt(max(x * x + y * y + z * z, _TINY))
    return x * scale, y * scale, z * scale


@part
def _swing(own: Float32, i: int, turn: Rotation) -> None:
    """Turn the whole arm of lane `i` about its shoulder."""
    sx, sy, sz = own[UPPER + 4, i], own[UPPER + 5, i], own[UPPER + 6, i]
    for row in (LOWER + 4, HAND + 4, PALM_ROW):
        x, y, z = turn_by(turn, own[row, i] - sx, own[row + 1, i] - sy, own[row + 2, i] - sz)
        own[row, i], own[row + 1, i], own[row + 2, i] = sx + x, sy + y, sz + z
    for row in (UPPER, LOWER, HAND):
        q = after(turn, (own[row, i], own[row + 1, i], own[row + 2, i], own[row + 3, i]))
        own[row, i], own[row + 1, i], own[row + 2, i], own[row + 3, i] = q


@part
def _follow(lead: Float32, own: Float32, share: Float32, start: int, stop: int) -> None:
    """Where the own palms of the block go, rows GOAL.. and SHARE: to the leaders', as far as arms reach.

    On the way there a palm keeps its distance from the shoulder and passes the front, and so does the arm with its
    elbow: turned to the front first and on from there, it never has to turn over, but behind the back.
    """
    for i in range(BLOCK):
        sx, sy, sz = own[UPPER + 4, i], own[UPPER + 5, i], own[UPPER + 6, i]
        gx, gy, gz = lead[PALM_ROW, i] - sx, lead[PALM_ROW + 1, i] - sy, lead[PALM_ROW + 2, i] - sz
        ex, ey, ez = own[PALM_ROW, i] - sx, own[PALM_ROW + 1, i] - sy, own[PALM_ROW + 2, i] - sz
        far = math.sqrt(max(gx * gx + gy * gy + gz * gz, _TINY))
        over = max(far - (own[REACH, i] - SOFT), _ZERO)
        far = far - over + SOFT * (_ONE - math.exp(-over / SOFT))
        near = math.sqrt(max(ex * ex + ey * ey + ez * ez, _TINY))
        gx, gy, gz = _unit(gx, gy, gz)
        ex, ey, ez = _unit(ex, ey, ez)
        side = ASIDE if own[SHARE, i] > _ZERO else -ASIDE  # a left hand's palm is at +x of its wrist
        fx, fz = own[FORWARD, i], own[FORWARD + 2, i]
        fx, fy, fz = _unit(fx + side * fz, own[FORWARD + 1, i] - ASIDE, fz - side * fx)
        w = share[min(start + i, stop - 1)]
        front = w * (_ONE - w) * (_ONE - (ex * gx + ey * gy + ez * gz))
        dx, dy, dz = _unit(
            (_ONE - w) * ex + w * gx + front * fx,
            (_ONE - w) * ey + w * gy + front * fy,
            (_ONE - w) * ez + w * gz + front * fz,
        )
        _swing(own, i, after(turn_from(fx, fy, fz, dx, dy, dz), turn_from(ex, ey, ez, fx, fy, fz)))
        # so that `bend_arm`, which goes the share of the way, comes to where the palm is to be now
        on = ((_ONE - w) * near + w * far - near) / max(w, _LEAST)
        own[GOAL, i], own[GOAL + 1, i], own[GOAL + 2, i] = (
            own[PALM_ROW, i] + on * dx,
            own[PALM_ROW + 1, i] + on * dy,
            own[PALM_ROW + 2, i] + on * dz,
        )
        own[SHARE, i] = w


@part
def _keep(
    lead: Float32, own: Float32, rotation: Float32, kept: Float32, who: Int32, joints: Int32, start: int, stop: int
) -> None:
    """Bring leaders' palms of the block as far as `kept` says to where they were seen from their followers' chests."""
    for n in range(start, stop):
        w, i, a, j = kept[n, 3], n - start, who[n, 1], joints[6]
        if w > _ZERO:
            chest = rotation[a, j, 0], rotation[a, j, 1], rotation[a, j, 2], rotation[a, j, 3]
            x, y, z = turn_by(chest, kept[n, 0], kept[n, 1], kept[n, 2])
            lead[PALM_ROW, i] += w * (own[UPPER + 4, i] + x - lead[PALM_ROW, i])
            lead[PALM_ROW + 1, i] += w * (own[UPPER + 5, i] + y - lead[PALM_ROW + 1, i])
            lead[PALM_ROW + 2, i] += w * (own[UPPER + 6, i] + z - lead[PALM_ROW + 2, i])


@kernel("void(f4[:,:,::1], f4[:,:,::1], i4[:,::1], i4[:,::1], f4[::1], f4[:,::1], i4[::1])")
def reach_palms(
    position: Float32, rotation: Float32, who: Int32, hand: Int32, share: Float32, kept: Float32, joints: Int32
) -> None:
    """Bring followers' palms to their leaders' in the poses `position` (A, J, 3) [m], `rotation` (A, J, 4), in place.

    `who` (H, 2): leader and follower of each hold, `hand` (H, 2): whose left (0) or right (1) hand; `share` (H,): how
    far the hold is closed, 0 to 1; `joints` as for `join_hands`. `kept` (H, 4): where the
    leader's palm was from the follower's shoulder as her chest sees it [m], and how far that counts instead of where
    it is, 0 to 1: a hand that is let go is followed no more. Only the follower's arm moves. A follower's arm is in
    one hold; who leads comes after what she herself reaches for. Beyond its reach an arm is straight, never longer.
    """
    lead, own = np.empty((ROWS, BLOCK), np.float32), np.empty((ROWS, BLOCK), np.float32)
    start = 0
    while start < len(who):
        stop = start + 1
        while stop < min(start + BLOCK, len(who)):
            waits = False  # whose leader's arm is moved in this block
            for n in range(start, stop):
                waits = waits or who[n, 1] == who[stop, 0]
            if waits:
                break
            stop += 1
        gather_arm(lead, position, rotation, who, hand, 0, joints, start, stop)
        gather_arm(own, position, rotation, who, hand, 1, joints, start, stop)
        _keep(lead, own, rotation, kept, who, joints, start, stop)
        _follow(lead, own, share, start, stop)
        bend_arm(own)
        scatter_arm(own, position, rotation, who, hand, 1, joints, start, stop)
        start = stop


@kernel("void(f4[:,:,::1], f4[:,:,::1], i4[:,::1], i4[:,::1], i4[::1], f4[:,::1])")
def see_palms(position: Float32, rotation: Float32, who: Int32, hand: Int32, joints: Int32, out: Float32) -> None:
    """What followers would have to reach, as in `reach_palms`, into `out` (H, 6): how much farther from her shoulder
    than her arm reaches the leader's palm is [m], below 0 within reach; the cosine between where her chest faces and
    where it is; how far it is from her own palm [m]; and where it is from her shoulder as her chest sees it [m]."""
    lead, own = np.empty((ROWS, BLOCK), np.float32), np.empty((ROWS, BLOCK), np.float32)
    for start in range(0, len(who), BLOCK):
        stop = min(start + BLOCK, len(who))
        gather_arm(lead, position, rotation, who, hand, 0, joints, start, stop)
        gather_arm(own, position, rotation, who, hand, 1, joints, start, stop)
        for i in range(stop - start):
            gx = lead[PALM_ROW, i] - own[UPPER + 4, i]
            gy = lead[PALM_ROW + 1, i] - own[UPPER + 5, i]
            gz = lead[PALM_ROW + 2, i] - own[UPPER + 6, i]
            far = math.sqrt(max(gx * gx + gy * gy + gz * gz, _TINY))
            out[start + i, 0] = far - own[REACH, i]
            out[start + i, 1] = (gx * own[FORWARD, i] + gy * own[FORWARD + 1, i] + gz * own[FORWARD + 2, i]) / far
            dx = lead[PALM_ROW, i] - own[PALM_ROW, i]
            dy = lead[PALM_ROW + 1, i] - own[PALM_ROW + 1, i]
            dz = lead[PALM_ROW + 2, i] - own[PALM_ROW + 2, i]
            a, j = who[start + i, 1], joints[6]
            back = rotation[a, j, 0], -rotation[a, j, 1], -rotation[a, j, 2], -rotation[a, j, 3]
            out[start + i, 3], out[start + i, 4], out[start + i, 5] = turn_by(back, gx, gy, gz)
            out[start + i, 2] = math.sqrt(dx * dx + dy * dy + dz * dz)
