"""Arm clearance: arms keep off other dancers (`neighbour_clearance_kernels`) and off the own trunk
(`trunk_clearance_kernels`); only arms that may need it are looked at more closely."""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.pose.body_capsules import TRUNK_AXIS_SHARE, TRUNK_HALF_WIDTH
from live.motion.pose.hand_hold_kernels import PALM
from live.motion.pose.neighbour_clearance_kernels import (
    BOX_PAD,
    TRUNK_BOX,
    draw_back_arms,
    find_pairs,
)
from live.motion.pose.sample_kernels import BLOCK
from live.motion.pose.trunk_clearance_kernels import ARM_GAP, HIPS, MARGIN, NECK, move_arms

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
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


@inline_kernel
def _find_arms(
    position: Float32, ahead: Float32, rotation: Float32, box: Float32, near: Bool, amount: Float32, trunk: Int32,
    arms: Int32,
) -> None:  # fmt: skip
    """Compute all dancers' boxes (4, A) at the places `ahead`, and which arms may be pushed out of the own trunk
    (2 A,)."""
    rows, edges = np.empty((_ROWS, BLOCK), np.float32), np.empty((4, BLOCK), np.float32)
    square = np.empty(BLOCK, np.float32)
    for start in range(0, len(position), BLOCK):
        stop = min(start + BLOCK, len(position))
        _gather_block(rows, ahead, rotation, trunk, arms, start, stop)
        _find_boxes(rows, edges)
        _gather_block(rows, position, rotation, trunk, arms, start, stop)
        for k in range(4):
            for i in range(stop - start):
                box[k, start + i] = edges[k, i]
        for side in range(2):
            _find_distances(rows, square, side)
            for i in range(stop - start):
                m = 2 * (start + i) + side
                near[m] = square[i] < _NEAR and amount[m] > _ZERO


@inline_kernel
def _size(drawn: Float32, m: int) -> Any:
    """Return about how far arm `m` draws back [m]."""
    return abs(drawn[m, 0, 0]) + abs(drawn[m, 0, 2]) + abs(drawn[m, 1, 0]) + abs(drawn[m, 1, 2])


@kernel("void(f4[:,:,::1], f4[:,:,::1], f4[:,:,::1], f4[:,:,::1], f4, b1, f4, i4[::1], i4[:,::1])")
def look_ahead(
    position: Float32, last: Float32, way: Float32, ahead: Float32, per: Any, later: bool, most: Any, trunk: Int32,
    arms: Int32,
) -> None:  # fmt: skip
    """Write to `ahead` (A, J, 3) where hips, necks and arms go from `position`, and `position` to `last` [m].

    They go on as since `last`, by `per` of that way, at most `most` [m] along each axis, if this frame is `later`; else
    by the `way` of before. Other joints of the arrays are not used.
    """
    for n in range(len(position)):
        for k in range(8):
            j = trunk[HIPS if k == 0 else NECK] if k < 2 else arms[(k - 2) // 3, (k - 2) % 3]
            for c in range(3):
                at = position[n, j, c]
                if later:
                    way[n, j, c] = min(max((at - last[n, j, c]) * per, -most), most)
                last[n, j, c] = at
                ahead[n, j, c] = at + way[n, j, c]


@inline_kernel
def _is_pushed(easing: Float32, m: int) -> bool:
    """Return whether arm `m` still returns from a push out of the own trunk; otherwise end it."""
    if len(easing) == 0:
        return False
    rest = _ZERO
    for k in range(easing.shape[1]):
        for c in range(6):
            rest = max(rest, abs(easing[1, k, m, c // 3, c % 3]))
    if rest < LEAST_DRAWN:
        easing[1, :, m] = _ZERO
    return bool(rest >= LEAST_DRAWN)


@inline_kernel
def _ease(drawn: Float32, easing: Float32, kept: Any, held: Float32) -> None:
    """Let `drawn` (M, 2, 3) follow what it was through equal low-pass filters, `easing` (K, M, 2, 3), of which `kept`
    stays; arms in a hold follow their hands instead, by `held` (M / 2, 2)."""
    for m in range(len(drawn)):
        rest = _ZERO
        for part in range(2):
            for c in range(3):
                value = drawn[m, part, c]
                for k in range(len(easing)):
                    value += kept * (easing[k, m, part, c] - value)
                    easing[k, m, part, c] = value
                    rest = max(rest, abs(value))
                drawn[m, part, c] = value * (_ONE - held[m // 2, m % 2]) if len(held) else value
        if rest < LEAST_DRAWN:
            drawn[m] = _ZERO
            easing[:, m] = _ZERO


@kernel(
    "void(f4[:,:,::1], f4[:,:,::1], f4[:,:,::1], f8[::1], f4[:,::1], i4[::1], f4[::1], b1[::1], "
    "f4[:,:,:,:,::1], f4[::1], i4[::1], i4[:,::1])"
)
def clear_arms(
    position: Float32, rotation: Float32, ahead: Float32, share: Float64, held: Float32, partner: Int32,
    together: Float32, visible: Bool, easing: Float32, kept: Float32, trunk: Int32, arms: Int32,
) -> None:  # fmt: skip
    """Keep all arms off other dancers and out of the own trunks, in poses (A, J, 3) [m] and (A, J, 4), in place.

    `ahead` (A, J, 3): where arms are about to be [m], by which they keep off others; `share` (A,): how far, 0 to 1;
    `held` (A, 2), `partner` (A,), `together` (A,) as in `HeldArms`, or all empty; others than `visible` dancers (A,)
    are in nobody's way; `easing` (2, K, 2 A, 2, 3), `kept` (2,): how arms kept off others and out of the own trunk so
    far and how much of it stays, or empty: at once; `trunk` (7,), `arms` (2, 3): joints as in `body_capsules`.
    """
    count = len(position)
    amount, near = np.empty(2 * count, np.float32), np.empty(2 * count, np.bool_)
    drawn, box = np.empty((2 * count, 2, 3), np.float32), np.empty((4, count), np.float32)
    which = np.empty(2 * count, np.int32)
    most = _ZERO
    for m in range(2 * count):
        amount[m] = share[m // 2] * (_ONE - held[m // 2, m % 2]) if len(held) else share[m // 2]
        most = max(most, amount[m])
    if most <= _ZERO:
        return
    _find_arms(position, ahead, rotation, box, near, amount, trunk, arms)
    pairs = find_pairs(box, visible)
    draw_back_arms(ahead, rotation, drawn, pairs, amount, held, partner, together, trunk, arms)
    if len(easing):
        _ease(drawn, easing[0], kept[0], held)
    moving = 0
    for m in range(2 * count):
        if near[m] or _size(drawn, m) > _ZERO or _is_pushed(easing, m):
            which[moving] = m
            moving += 1
    none = np.empty((0, 0, 2, 3), np.float32)
    pushes = easing[1] if len(easing) else none
    move_arms(position, rotation, drawn, amount, which, moving, pushes, kept[1], trunk, arms)
