"""Trunk clearance: pushes arms out of the own trunk, and turns arms so that elbow and wrist are where they were pushed.

The trunk is the capsule of `body_capsules`. Points along forearm and palm are pushed out the shortest way, in blocks of
arms with one row per number (see `sample_kernels`); then two-bone IK restores the lengths, with the elbow towards where
it was pushed. It is continuous in the poses: an arm is moved the more the farther it is in, beginning a little before
it touches. In the frames of a show the push passes low-pass filters besides (`ArmEasing`).
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.pose.body_capsules import TRUNK_AXIS_SHARE, TRUNK_END, TRUNK_HALF_DEPTH, TRUNK_HALF_WIDTH
from live.motion.pose.hand_hold_kernels import PALM, multiply, rotate_vector, shortest_rotation
from live.motion.pose.sample_kernels import BLOCK

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

ARM_GAP: Any = np.float32(0.03)
"""A forearm's axis stays this far [m] from the own trunk's surface: its radius."""
PALM_GAP: Any = np.float32(0.015)
"""... and the palm's middle this far."""
MARGIN: Any = np.float32(0.02)
"""The push begins this far [m] before the gap is reached, and is whole as far behind it."""
ELBOW_BIAS: Any = np.float32(0.6)
"""Bias of a straight arm's elbow downwards and backwards, as a share of the way of elbow and hand ..."""
BENT, STRAIGHT = np.float32(0.75), np.float32(0.98)
"""... none for an arm whose wrist is as far from the shoulder as BENT of its length, all from STRAIGHT on."""
BACKWARD: Any = np.float32(0.3)
"""The bias points backwards by this share of what it points downwards."""
STAYING: Any = np.float32(0.9)
"""Share of the way from the elbow to the line from shoulder to wrist that a push towards it never exceeds."""
LENGTH_BUFFER: Any = np.float32(0.003)
"""An arm is not stretched beyond its length minus this [m], unless the clip itself stretches it farther."""
ROUNDS = 2
"""Pushes out of the own trunk, each followed by IK."""
HIPS, CHEST, NECK, LEFT_LEG, RIGHT_LEG, LEFT_SHOULDER, RIGHT_SHOULDER = range(7)
"""Entries of `trunk`."""
_AXIS, _BEND, _LOW, _HIGH, _PER, TRUNK_ROWS = 3, 6, 9, 12, 15, 16
"""Rows of a trunk: hips, axis, bend of the axis, wide side below and above, 1 / squared length of the axis."""
_ELBOW, _WRIST, _PALM, _BACK, _UPPER, _LOWER, _REACH, _SHARE = 3, 6, 9, 12, 15, 16, 17, 18
_MOVED, _DRAWN, _BEFORE, ARM_ROWS = 19, 20, 26, 32
"""Rows of an arm: shoulder, elbow, wrist, from wrist to palm, backward direction of the upper arm; lengths of upper arm
and forearm, the farthest the wrist may be from the shoulder, share of the push, how far points were pushed so far; by
how much elbow and wrist are displaced at first, and where they were before."""
_ZERO: Any = np.float32(0.0)
_HALF: Any = np.float32(0.5)
_ONE: Any = np.float32(1.0)
_TWO: Any = np.float32(2.0)
_THREE: Any = np.float32(3.0)
_FOUR: Any = np.float32(4.0)
_TINY: Any = np.float32(1e-12)
_LEAST_PUSH: Any = np.float32(1e-6)
_AXIS_SHARE: Any = np.float32(TRUNK_AXIS_SHARE)
_WIDE, _DEEP, _END = (np.float32(1.0 / size**2) for size in (TRUNK_HALF_WIDTH, TRUNK_HALF_DEPTH, TRUNK_END))
_CORE: Any = np.float32(0.7)
"""Squared share of the trunk's size within which pushes fade to nothing: at the axis no way out is the shortest, so a
hand that passes from the front to the back passes through, instead of jumping from one side to the other."""


@inline_kernel
def soft(x: Any, margin: Any) -> Any:
    """Return about max(x, 0), with a continuous slope: a parabola within `margin` of 0."""
    q = min(max(x + margin, _ZERO), _TWO * margin)
    return q * q / (_FOUR * margin) + max(x - margin, _ZERO)


@inline_kernel
def _gather_trunks(rows: Float32, position: Float32, trunk: Int32, which: Int32, start: int, stop: int) -> None:
    """Compute the trunks of the block's arms; lanes beyond the last arm repeat the last one."""
    for i in range(BLOCK):
        n = which[min(start + i, stop - 1)] // 2
        for c in range(3):
            hips = position[n, trunk[HIPS], c]
            rows[c, i] = hips
            rows[_AXIS + c, i] = _AXIS_SHARE * (position[n, trunk[NECK], c] - hips)
            rows[_BEND + c, i] = position[n, trunk[CHEST], c] - hips
            rows[_LOW + c, i] = position[n, trunk[LEFT_LEG], c] - position[n, trunk[RIGHT_LEG], c]
            rows[_HIGH + c, i] = position[n, trunk[LEFT_SHOULDER], c] - position[n, trunk[RIGHT_SHOULDER], c]
    for i in range(BLOCK):
        ax, ay, az = rows[_AXIS, i], rows[_AXIS + 1, i], rows[_AXIS + 2, i]
        rows[_PER, i] = _ONE / max(ax * ax + ay * ay + az * az, _TINY)
    for first in (_BEND, _LOW, _HIGH):
        for i in range(BLOCK):
            ax, ay, az = rows[_AXIS, i], rows[_AXIS + 1, i], rows[_AXIS + 2, i]
            x, y, z = rows[first, i], rows[first + 1, i], rows[first + 2, i]
            on = (x * ax + y * ay + z * az) * rows[_PER, i]
            x, y, z = x - on * ax, y - on * ay, z - on * az
            scale = _ONE if first == _BEND else _ONE / math.sqrt(max(x * x + y * y + z * z, _TINY))
            rows[first, i], rows[first + 1, i], rows[first + 2, i] = x * scale, y * scale, z * scale


@inline_kernel
def _keep_places(arm: Float32) -> None:
    """Keep where elbow and wrist are before they are pushed."""
    for c in range(6):
        for i in range(BLOCK):
            arm[_BEFORE + c, i] = arm[_ELBOW + c, i]


@inline_kernel
def _gather_arms(
    arm: Float32, rows: Float32, position: Float32, rotation: Float32, drawn: Float32, amount: Float32, arms: Int32,
    which: Int32, start: int, stop: int,
) -> None:  # fmt: skip
    """Copy the block's arms into rows, elbow and wrist displaced by `drawn`."""
    for i in range(BLOCK):
        m = which[min(start + i, stop - 1)]
        n, side = m // 2, m % 2
        upper, lower, hand = arms[side, 0], arms[side, 1], arms[side, 2]
        palm = PALM if side == 0 else -PALM
        moved = _ZERO
        for c in range(3):
            arm[c, i] = position[n, upper, c]
            arm[_ELBOW + c, i] = position[n, lower, c]
            arm[_WRIST + c, i] = position[n, hand, c]
            arm[_DRAWN + c, i] = drawn[m, 0, c]
            arm[_DRAWN + 3 + c, i] = drawn[m, 1, c]
            moved += abs(drawn[m, 0, c]) + abs(drawn[m, 1, c])
        w, x, y, z = rotation[n, hand, 0], rotation[n, hand, 1], rotation[n, hand, 2], rotation[n, hand, 3]
        arm[_PALM, i] = palm * (_ONE - _TWO * (y * y + z * z))
        arm[_PALM + 1, i] = palm * _TWO * (x * y + w * z)
        arm[_PALM + 2, i] = palm * _TWO * (x * z - w * y)
        scale = BACKWARD * math.sqrt(rows[_PER, i])
        ax, ay, az = rows[_AXIS, i] * scale, rows[_AXIS + 1, i] * scale, rows[_AXIS + 2, i] * scale
        sx, sy, sz = rows[_HIGH, i], rows[_HIGH + 1, i], rows[_HIGH + 2, i]
        arm[_BACK, i] = ay * sz - az * sy
        arm[_BACK + 1, i] = az * sx - ax * sz - _ONE
        arm[_BACK + 2, i] = ax * sy - ay * sx
        arm[_SHARE, i] = amount[m]
        arm[_MOVED, i] = moved
    for i in range(BLOCK):
        sx, sy, sz = arm[0, i], arm[1, i], arm[2, i]
        ux, uy, uz = arm[_ELBOW, i] - sx, arm[_ELBOW + 1, i] - sy, arm[_ELBOW + 2, i] - sz
        ex, ey, ez = arm[_WRIST, i] - sx, arm[_WRIST + 1, i] - sy, arm[_WRIST + 2, i] - sz
        lx, ly, lz = ex - ux, ey - uy, ez - uz
        upper = math.sqrt(ux * ux + uy * uy + uz * uz)
        lower = math.sqrt(lx * lx + ly * ly + lz * lz)
        own = math.sqrt(ex * ex + ey * ey + ez * ez)
        arm[_UPPER, i], arm[_LOWER, i] = upper, lower
        arm[_REACH, i] = max(upper + lower - LENGTH_BUFFER, own)
        bias = min(max((own / max(upper + lower, _TINY) - BENT) / (STRAIGHT - BENT), _ZERO), _ONE)
        bias = ELBOW_BIAS * bias * bias * (_THREE - _TWO * bias)
        arm[_BACK, i], arm[_BACK + 1, i], arm[_BACK + 2, i] = (
            arm[_BACK, i] * bias, arm[_BACK + 1, i] * bias, arm[_BACK + 2, i] * bias
        )  # fmt: skip
    _keep_places(arm)
    for c in range(3):
        for i in range(BLOCK):
            arm[_ELBOW + c, i] += arm[_DRAWN + c, i]
            arm[_WRIST + c, i] += arm[_DRAWN + 3 + c, i]


@inline_kernel
def _push_out(arm: Float32, rows: Float32, at: Any, beyond: Any, gap: Any) -> None:
    """Push one point of each arm out of the own trunk the shortest way: at the share `at` of the forearm, and the share
    `beyond` of the way from the wrist to the palm. Elbow and wrist take as much of it as moves the point by all of it.

    The distance to an ellipse is that of first order, |p| (|p| - 1) / |grad|, p in units of the trunk's size.
    """
    to_elbow, to_wrist = (_ONE - at), at
    norm = to_elbow * to_elbow + to_wrist * to_wrist
    to_elbow, to_wrist = to_elbow / norm, to_wrist / norm
    for i in range(BLOCK):
        x = arm[_ELBOW, i] + at * (arm[_WRIST, i] - arm[_ELBOW, i]) + beyond * arm[_PALM, i] - rows[0, i]
        y = arm[_ELBOW + 1, i] + at * (arm[_WRIST + 1, i] - arm[_ELBOW + 1, i]) + beyond * arm[_PALM + 1, i]
        z = arm[_ELBOW + 2, i] + at * (arm[_WRIST + 2, i] - arm[_ELBOW + 2, i]) + beyond * arm[_PALM + 2, i]
        y, z = y - rows[1, i], z - rows[2, i]
        ax, ay, az = rows[_AXIS, i], rows[_AXIS + 1, i], rows[_AXIS + 2, i]
        per = rows[_PER, i]
        t = min(max((x * ax + y * ay + z * az) * per, _ZERO), _ONE)
        bent = _FOUR * t * (_ONE - t)
        x, y, z = (
            x - t * ax - bent * rows[_BEND, i],
            y - t * ay - bent * rows[_BEND + 1, i],
            z - t * az - bent * rows[_BEND + 2, i],
        )
        sx = rows[_LOW, i] + t * (rows[_HIGH, i] - rows[_LOW, i])
        sy = rows[_LOW + 1, i] + t * (rows[_HIGH + 1, i] - rows[_LOW + 1, i])
        sz = rows[_LOW + 2, i] + t * (rows[_HIGH + 2, i] - rows[_LOW + 2, i])
        scale = _ONE / math.sqrt(max(sx * sx + sy * sy + sz * sz, _TINY))
        sx, sy, sz = sx * scale, sy * scale, sz * scale
        scale = math.sqrt(per)
        ax, ay, az = ax * scale, ay * scale, az * scale
        fx, fy, fz = ay * sz - az * sy, az * sx - ax * sz, ax * sy - ay * sx
        u, v, w = x * sx + y * sy + z * sz, x * fx + y * fy + z * fz, x * ax + y * ay + z * az
        gu, gv, gw = u * _WIDE, v * _DEEP, w * _END
        square = u * gu + v * gv + w * gw
        gradient = _ONE / math.sqrt(max(gu * gu + gv * gv + gw * gw, _TINY))
        outside = (square - math.sqrt(square)) * gradient
        core = min(square / _CORE, _ONE)
        push = arm[_SHARE, i] * core * core * (_THREE - _TWO * core) * soft(gap - outside, MARGIN)
        arm[_MOVED, i] += push
        push *= gradient
        x = push * (gu * sx + gv * fx + gw * ax)
        y = push * (gu * sy + gv * fy + gw * ay)
        z = push * (gu * sz + gv * fz + gw * az)
        arm[_ELBOW, i] += to_elbow * x
        arm[_ELBOW + 1, i] += to_elbow * y
        arm[_ELBOW + 2, i] += to_elbow * z
        arm[_WRIST, i] += to_wrist * x
        arm[_WRIST + 1, i] += to_wrist * y
        arm[_WRIST + 2, i] += to_wrist * z


@inline_kernel
def _place_arm(arm: Float32, i: int, gx: Any, gy: Any, gz: Any, length: Any, px: Any, py: Any, pz: Any) -> None:
    """Put the wrist of arm `i` `length` [m] from its shoulder along g (unit), and the elbow on the side of p."""
    upper, lower = arm[_UPPER, i], arm[_LOWER, i]
    along = (upper * upper - lower * lower + length * length) / (_TWO * length)
    aside = math.sqrt(max(upper * upper - along * along, _ZERO))
    on = px * gx + py * gy + pz * gz
    px, py, pz = px - on * gx, py - on * gy, pz - on * gz
    scale = aside / math.sqrt(max(px * px + py * py + pz * pz, _TINY))
    arm[_ELBOW, i] = arm[0, i] + along * gx + scale * px
    arm[_ELBOW + 1, i] = arm[1, i] + along * gy + scale * py
    arm[_ELBOW + 2, i] = arm[2, i] + along * gz + scale * pz
    arm[_WRIST, i] = arm[0, i] + length * gx
    arm[_WRIST + 1, i] = arm[1, i] + length * gy
    arm[_WRIST + 2, i] = arm[2, i] + length * gz


@inline_kernel
def _restore_lengths(arm: Float32) -> None:
    """Two-bone IK of positions: the wrist within reach, the elbow swung with the arm and turned to where it was pushed.

    An elbow never passes through the line from shoulder to wrist, where it would flip: of a push towards that line no
    more than STAYING of the way counts. Both places are unchanged where nothing was pushed, but for rounding.
    """
    for i in range(BLOCK):
        sx, sy, sz = arm[0, i], arm[1, i], arm[2, i]
        gx, gy, gz = arm[_WRIST, i] - sx, arm[_WRIST + 1, i] - sy, arm[_WRIST + 2, i] - sz
        ux, uy, uz = arm[_BEFORE, i] - sx, arm[_BEFORE + 1, i] - sy, arm[_BEFORE + 2, i] - sz
        ex, ey, ez = arm[_BEFORE + 3, i] - sx, arm[_BEFORE + 4, i] - sy, arm[_BEFORE + 5, i] - sz
        upper, lower, moved = arm[_UPPER, i], arm[_LOWER, i], arm[_MOVED, i]
        size = math.sqrt(max(gx * gx + gy * gy + gz * gz, _TINY))
        length = min(max(size, abs(upper - lower) + LENGTH_BUFFER), arm[_REACH, i])
        swing = shortest_rotation(ex, ey, ez, gx, gy, gz)
        gx, gy, gz = gx / size, gy / size, gz / size
        on = (ux * ex + uy * ey + uz * ez) / max(ex * ex + ey * ey + ez * ez, _TINY)
        ux, uy, uz = rotate_vector(
            swing,
            ux - on * ex + moved * arm[_BACK, i],
            uy - on * ey + moved * arm[_BACK + 1, i],
            uz - on * ez + moved * arm[_BACK + 2, i],
        )
        on = ux * gx + uy * gy + uz * gz
        ux, uy, uz = ux - on * gx, uy - on * gy, uz - on * gz  # how the elbow stands off the line
        px = arm[_ELBOW, i] - arm[_BEFORE, i]
        py = arm[_ELBOW + 1, i] - arm[_BEFORE + 1, i]
        pz = arm[_ELBOW + 2, i] - arm[_BEFORE + 2, i]
        off = math.sqrt(max(ux * ux + uy * uy + uz * uz, _TINY))
        inwards = -(px * ux + py * uy + pz * uz) / off
        most = STAYING * off
        over = max(inwards, _ZERO)
        back = over - most * over / (most + over)
        px, py, pz = px + ux + back * ux / off, py + uy + back * uy / off, pz + uz + back * uz / off
        _place_arm(arm, i, gx, gy, gz, length, px, py, pz)


@inline_kernel
def _write_arms(
    arm: Float32, position: Float32, rotation: Float32, arms: Int32, which: Int32, start: int, stop: int
) -> None:
    """Turn the arms of the block that were pushed; the others keep every bit. Hands keep their angle to the forearm."""
    for i in range(stop - start):
        if arm[_MOVED, i] <= _LEAST_PUSH:
            continue
        n, side = which[start + i] // 2, which[start + i] % 2
        upper, lower, hand = arms[side, 0], arms[side, 1], arms[side, 2]
        ex, ey, ez = position[n, lower, 0], position[n, lower, 1], position[n, lower, 2]
        wx, wy, wz = position[n, hand, 0] - ex, position[n, hand, 1] - ey, position[n, hand, 2] - ez
        ex, ey, ez = ex - arm[0, i], ey - arm[1, i], ez - arm[2, i]
        raised = shortest_rotation(
            ex, ey, ez, arm[_ELBOW, i] - arm[0, i], arm[_ELBOW + 1, i] - arm[1, i], arm[_ELBOW + 2, i] - arm[2, i]
        )
        bent = shortest_rotation(
            wx, wy, wz,
            arm[_WRIST, i] - arm[_ELBOW, i],
            arm[_WRIST + 1, i] - arm[_ELBOW + 1, i],
            arm[_WRIST + 2, i] - arm[_ELBOW + 2, i],
        )  # fmt: skip
        for j, turn in ((upper, raised), (lower, bent), (hand, bent)):
            q = multiply(turn, (rotation[n, j, 0], rotation[n, j, 1], rotation[n, j, 2], rotation[n, j, 3]))
            rotation[n, j, 0], rotation[n, j, 1], rotation[n, j, 2], rotation[n, j, 3] = q
        for c in range(3):
            position[n, lower, c] = arm[_ELBOW + c, i]
            position[n, hand, c] = arm[_WRIST + c, i]


@inline_kernel
def _ease_pushes(
    arm: Float32, position: Float32, arms: Int32, which: Int32, start: int, stop: int, easing: Float32, kept: Any
) -> None:
    """Let what elbows and wrists of the block were pushed follow what it was, through equal low-pass filters."""
    for i in range(stop - start):
        m = which[start + i]
        for c in range(6):
            there = position[m // 2, arms[m % 2, 1 + c // 3], c % 3] + arm[_DRAWN + c, i]
            value = arm[_ELBOW + c, i] - there
            for k in range(len(easing)):
                value += kept * (easing[k, m, c // 3, c % 3] - value)
                easing[k, m, c // 3, c % 3] = value
            arm[_ELBOW + c, i] = there + value
            arm[_MOVED, i] += abs(value)
    for i in range(BLOCK):  # lengths again, the elbow in the plane where it is
        sx, sy, sz = arm[0, i], arm[1, i], arm[2, i]
        gx, gy, gz = arm[_WRIST, i] - sx, arm[_WRIST + 1, i] - sy, arm[_WRIST + 2, i] - sz
        ux, uy, uz = arm[_ELBOW, i] - sx, arm[_ELBOW + 1, i] - sy, arm[_ELBOW + 2, i] - sz
        upper, lower = arm[_UPPER, i], arm[_LOWER, i]
        size = math.sqrt(max(gx * gx + gy * gy + gz * gz, _TINY))
        length = min(max(size, abs(upper - lower) + LENGTH_BUFFER), arm[_REACH, i])
        _place_arm(arm, i, gx / size, gy / size, gz / size, length, ux, uy, uz)


@kernel("void(f4[:,:,::1], f4[:,:,::1], f4[:,:,::1], f4[::1], i4[::1], i8, f4[:,:,:,::1], f4, i4[::1], i4[:,::1])")
def move_arms(
    position: Float32, rotation: Float32, drawn: Float32, amount: Float32, which: Int32, count: int, easing: Float32,
    kept: Any, trunk: Int32, arms: Int32,
) -> None:  # fmt: skip
    """Displace arms by `drawn` and push them out of the own trunks, in poses (A, J, 3) [m] and (A, J, 4), in place.

    Arms are numbered 2 dancer + side; `which`: the first `count` of it are those arms. `drawn` (2 A, 2, 3):
    displacement of elbow and wrist [m]; `amount` (2 A,): how much of the push is applied, 0 to 1; `trunk` (7,), `arms`
    (2, 3): joints as in `body_capsules`; `easing` (K, 2 A, 2, 3), `kept`: low-pass filters of the push and how much of
    them stays, or empty: at once.
    """
    rows, arm = np.empty((TRUNK_ROWS, BLOCK), np.float32), np.empty((ARM_ROWS, BLOCK), np.float32)
    for start in range(0, count, BLOCK):
        stop = min(start + BLOCK, count)
        _gather_trunks(rows, position, trunk, which, start, stop)
        _gather_arms(arm, rows, position, rotation, drawn, amount, arms, which, start, stop)
        for _ in range(ROUNDS):
            for k in range(4):  # three points of the forearm, and the palm
                palm = k == 3
                at = _ONE if palm else _HALF * np.float32(k)
                _push_out(arm, rows, at, _ONE if palm else _ZERO, PALM_GAP if palm else ARM_GAP)
            _restore_lengths(arm)
            _keep_places(arm)
        if len(easing):
            _ease_pushes(arm, position, arms, which, start, stop, easing, kept)
        _write_arms(arm, position, rotation, arms, which, start, stop)
