"""Arm clearance: arms keep off other dancers (`neighbour_clearance_kernels`) and off the own trunk
(`trunk_clearance_kernels`); only arms that may need it are looked at more closely."""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.pose.body_capsules import TRUNK_AXIS_SHARE, TRUNK_HALF_WIDTH
from live.motion.pose.hand_hold_kernels import PALM
from live.motion.pose.neighbour_clearance_kernels import BOX_PAD, TRUNK_BOX
from live.motion.pose.sample_kernels import BLOCK
from live.motion.pose.trunk_clearance_kernels import ARM_GAP, HIPS, MARGIN, NECK

Float32 = npt.NDArray[np.float32]
Bool = npt.NDArray[np.bool_]
Int32 = npt.NDArray[np.int32]

LEAST_DRAWN: Any = np.float32(1e-4)
"""Arms that draw back by less [m] are not moved."""
TRUNK_BEND: Any = np.float32(0.06)
"""The trunk's axis is bent away from the line between hips and neck by at most this [m]."""
_NEAR: Any = np.float32((TRUNK_HALF_WIDTH + 0.06 + float(ARM_GAP) + float(MARGIN)) ** 2)
_HIPS, _NECK, _ARMS, _ROWS = 0, 3, 6, 24
"""Rows of a block: hips and neck, then elbow, wrist and palm of the left and the right arm."""
_AXIS_SHARE: Any = np.float32(TRUNK_AXIS_SHARE)
_ZERO: Any = np.float32(0.0)
_HALF: Any = np.float32(0.5)
_ONE: Any = np.float32(1.0)
_TWO: Any = np.float32(2.0)
_TINY: Any = np.float32(1e-12)


@inline_kernel
def _gather_block(
    rows: Float32, position: Float32, rotation: Float32, trunk: Int32, arms: Int32, start: int, stop: int
) -> None:
    """Copy the joints of the block's dancers; lanes beyond the last dancer repeat the last one."""
    for i in range(BLOCK):
        n = min(start + i, stop - 1)
        for c in range(3):
            rows[_HIPS + c, i], rows[_NECK + c, i] = position[n, trunk[HIPS], c], position[n, trunk[NECK], c]
        for side in range(2):
            first, hand = _ARMS + 9 * side, arms[side, 2]
            w, x, y, z = rotation[n, hand, 0], rotation[n, hand, 1], rotation[n, hand, 2], rotation[n, hand, 3]
            palm = PALM if side == 0 else -PALM
            for c in range(3):
                rows[first + c, i] = position[n, arms[side, 1], c]
                rows[first + 3 + c, i] = position[n, hand, c]
            rows[first + 6, i] = position[n, hand, 0] + palm * (_ONE - _TWO * (y * y + z * z))
            rows[first + 7, i] = position[n, hand, 1] + palm * _TWO * (x * y + w * z)
            rows[first + 8, i] = position[n, hand, 2] + palm * _TWO * (x * z - w * y)


@inline_kernel
def _find_boxes(rows: Float32, edges: Float32) -> None:
    """Compute the edges of what the block's dancers fill on the floor (4, BLOCK), with the pad."""
    for axis in range(2):  # x, z
        c = 2 * axis
        for i in range(BLOCK):
            hips, neck = rows[_HIPS + c, i], rows[_NECK + c, i]
            low, high = min(hips, neck) - TRUNK_BOX, max(hips, neck) + TRUNK_BOX
            for k in range(6):
                low, high = min(low, rows[_ARMS + 3 * k + c, i]), max(high, rows[_ARMS + 3 * k + c, i])
            edges[2 * axis, i], edges[2 * axis + 1, i] = low - BOX_PAD, high + BOX_PAD


@inline_kernel
def _find_distances(rows: Float32, square: Float32, side: int) -> None:
    """Compute the squared distance of the arms of one side to the line from hips to neck (BLOCK,), by the points that
    are pushed out of the trunk."""
    first = _ARMS + 9 * side
    for i in range(BLOCK):
        hx, hy, hz = rows[_HIPS, i], rows[_HIPS + 1, i], rows[_HIPS + 2, i]
        ax, ay, az = rows[_NECK, i] - hx, rows[_NECK + 1, i] - hy, rows[_NECK + 2, i] - hz
        ax, ay, az = _AXIS_SHARE * ax, _AXIS_SHARE * ay, _AXIS_SHARE * az
        per = _ONE / max(ax * ax + ay * ay + az * az, _TINY)
        nearest = _ONE
        for k in range(4):
            ex, ey, ez = rows[first, i] - hx, rows[first + 1, i] - hy, rows[first + 2, i] - hz
            wx, wy, wz = rows[first + 3, i] - hx, rows[first + 4, i] - hy, rows[first + 5, i] - hz
            px, py, pz = rows[first + 6, i] - hx, rows[first + 7, i] - hy, rows[first + 8, i] - hz
            elbow = _HALF if k == 1 else (_ONE if k == 0 else _ZERO)
            wrist = _HALF if k == 1 else (_ONE if k == 2 else _ZERO)
            palm = _ONE if k == 3 else _ZERO
            x = elbow * ex + wrist * wx + palm * px
            y = elbow * ey + wrist * wy + palm * py
            z = elbow * ez + wrist * wz + palm * pz
            t = min(max((x * ax + y * ay + z * az) * per, _ZERO), _ONE)
            x, y, z = x - t * ax, y - t * ay, z - t * az
            nearest = min(nearest, x * x + y * y + z * z)
        square[i] = nearest


@kernel("void(f4[:,:,::1], f4[:,:,::1], f4[:,:,::1], f4[:,::1], b1[:,::1], f4[:,::1], i4[::1], i4[:,::1], i8, i8)")
def find_arms(
    position: Float32, ahead: Float32, rotation: Float32, box: Float32, near: Bool, amount: Float32, trunk: Int32,
    arms: Int32, begin: int, end: int,
) -> None:  # fmt: skip
    """Compute the boxes (4, A) of the dancers begin..end-1 at the places `ahead` (A, J, 3), and which of their arms may
    be pushed out of the own trunk, `near` (A, 2), by an `amount` (A, 2) above 0; other arrays as in `move_arms`."""
    rows, edges = np.empty((_ROWS, BLOCK), np.float32), np.empty((4, BLOCK), np.float32)
    square = np.empty(BLOCK, np.float32)
    for start in range(begin, end, BLOCK):
        stop = min(start + BLOCK, end)
        for later in (True, False):
            _gather_block(rows, ahead if later else position, rotation, trunk, arms, start, stop)
            if later:
                _find_boxes(rows, edges)
        for k in range(4):
            for i in range(stop - start):
                box[k, start + i] = edges[k, i]
        for side in range(2):
            _find_distances(rows, square, side)
            for i in range(stop - start):
                near[start + i, side] = square[i] < _NEAR and amount[start + i, side] > _ZERO


@kernel("void(f4[:,:,::1], f4[:,:,::1], f4[:,:,::1], f4[:,:,::1], f4, b1, f4, i4[::1], i4[:,::1], i8, i8)")
def look_ahead(
    position: Float32, last: Float32, way: Float32, ahead: Float32, per: Any, later: bool, most: Any, trunk: Int32,
    arms: Int32, begin: int, end: int,
) -> None:  # fmt: skip
    """Write to `ahead` (A, J, 3) where hips, necks and arms of the dancers begin..end-1 go from `position`, and
    `position` to `last` [m].

    They go on as since `last`, by `per` of that way, at most `most` [m] along each axis, if this frame is `later`; else
    by the `way` of before. Other joints of the arrays are not used.
    """
    for n in range(begin, end):
        for k in range(8):
            j = trunk[HIPS if k == 0 else NECK] if k < 2 else arms[(k - 2) // 3, (k - 2) % 3]
            for c in range(3):
                at = position[n, j, c]
                if later:
                    way[n, j, c] = min(max((at - last[n, j, c]) * per, -most), most)
                last[n, j, c] = at
                ahead[n, j, c] = at + way[n, j, c]


@inline_kernel
def _largest(ways: Float32) -> Any:
    """Return the largest of the numbers of an arm (2, 3)."""
    most = _ZERO
    for c in range(6):
        most = max(most, abs(ways[c // 3, c % 3]))
    return most


@inline_kernel
def _forget(filters: Float32, unused: bool) -> None:
    """Set the filters of an arm (2, 3) that is `unused` to 0."""
    for c in range(6 if unused else 0):
        filters[c // 3, c % 3] = _ZERO


@kernel("void(f4[:,:,::1], f4[:,:,:,:,::1], f4[::1], f4[:,::1], b1[:,::1], b1[:,::1], b1[:,::1], i8, i8)")
def ease_arms(
    drawn: Float32, easing: Float32, kept: Float32, held: Float32, near: Bool, active: Bool, moves: Bool, begin: int,
    end: int,
) -> None:  # fmt: skip
    """Let what the arms of the dancers begin..end-1 draw back, `drawn` (2 A, 2, 3), follow what it was through equal
    low-pass filters; arms in a hold, by `held` (A, 2), follow their hands instead. Find which arms are to be moved.

    `easing` (2, K, 2 A, 2, 3), `kept` (2,): as in `ArmEasing`, or empty: at once. `moves` (A, 2): arms that draw back,
    still return from a push out of the own trunk, or are `near` (A, 2) to it. The filters of arms that are not `active`
    (A, 2) are 0; this is updated.
    """
    for m in range(2 * begin, 2 * end):
        n, side = m // 2, m % 2
        if not active[n, side] and _largest(drawn[m]) == _ZERO:
            active[n, side] = moves[n, side] = near[n, side]
            continue
        eased = rest = _ZERO
        for k in range(easing.shape[1]):
            for c in range(6):
                before = drawn[m, c // 3, c % 3] if k == 0 else easing[0, k - 1, m, c // 3, c % 3]
                easing[0, k, m, c // 3, c % 3] = before + kept[0] * (easing[0, k, m, c // 3, c % 3] - before)
            eased, rest = max(eased, _largest(easing[0, k, m])), max(rest, _largest(easing[1, k, m]))
        for c in range(6 if len(easing) else 0):
            value = easing[0, easing.shape[1] - 1, m, c // 3, c % 3] if eased >= LEAST_DRAWN else _ZERO
            drawn[m, c // 3, c % 3] = value * (_ONE - held[n, side]) if len(held) else value
        draws = abs(drawn[m, 0, 0]) + abs(drawn[m, 0, 2]) + abs(drawn[m, 1, 0]) + abs(drawn[m, 1, 2]) > _ZERO
        moves[n, side] = near[n, side] or draws or rest >= LEAST_DRAWN
        active[n, side] = moves[n, side] or eased >= LEAST_DRAWN
        for k in range(easing.shape[1]):
            _forget(easing[0, k, m], eased < LEAST_DRAWN)
            _forget(easing[1, k, m], not moves[n, side])
