"""Inertialization kernels: the pose difference at a cut between clips is added back and fades within 0.4 s.

Bollo, "Inertialization: High-Performance Animation Transitions in Gears of War" (GDC 2018): only the difference
between the two clips at the cut is kept, a value and a speed per joint, and fades to zero along a quintic. Here a
difference is a rotation vector [rad] in the axes of the joint's parent (for the hips also a translation [m]), and the
quintic starts with zero acceleration:

    x(t) = x0 P(s) + v0 T Q(s),  P = (1 - s)^3 (1 + 3 s + 6 s^2),  Q = s (1 - s)^3 (1 + 3 s),  s = t / T

Value and speed are continuous at the cut, and value, speed and acceleration are 0 at T. Bollo shortens T where the
speed would make the difference cross 0. P / Q is never below 2.5, so it does not cross for |v0| T <= 2.5 |x0|. T is at
least SHORTEST, because a short T is a hard jerk; then the difference crosses 0 by at most 0.2 T |v0|, the largest Q.
Speeds away from 0 are kept, unlike in Bollo, so the cut is always C1.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.pose.sample_kernels import BLOCK

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

MAX_FADE_TIME = 0.4
"""Time after which a difference is zero [s]."""
MIN_FADE_TIME = 0.2
"""Minimum fade time of a difference [s]."""
OFFSET_X, OFFSET_Y, OFFSET_Z, SPEED_X, SPEED_Y, SPEED_Z, DURATION = range(7)
"""Columns of a joint: difference at the cut, its speed [1/s], and its fade time [s]."""
COLUMNS = 7
_ZERO: Any = np.float32(0.0)
_QUARTER: Any = np.float32(0.25)
_HALF: Any = np.float32(0.5)
_ONE: Any = np.float32(1.0)
_THREE: Any = np.float32(3.0)
_SIX: Any = np.float32(6.0)
_C2, _C4, _C6, _C8, _C10, _C12 = (np.float32((-1) ** (n // 2) / math.factorial(n)) for n in range(2, 14, 2))
_S3, _S5, _S7, _S9, _S11 = (np.float32((-1) ** (n // 2) / math.factorial(n)) for n in range(3, 13, 2))


@inline_kernel
def _remaining(settling: Float32, age: Float32, joint: int, left: Float32, start: int, stop: int) -> None:
    """Compute the remaining difference of one joint, rows 0 to 2 of `left`."""
    for i in range(BLOCK):
        n = min(start + i, stop - 1)
        row = settling[n, joint]
        s = min(max(age[n] / row[DURATION], _ZERO), _ONE)
        fall = (_ONE - s) * (_ONE - s) * (_ONE - s)
        value = fall * (_ONE + s * (_THREE + _SIX * s))
        speed = fall * s * (_ONE + _THREE * s) * row[DURATION]
        for c in range(3):
            left[c, i] = value * row[c] + speed * row[3 + c]


@kernel("void(f4[:,:,::1], f4[:,::1], f4[:,:,::1], f4[::1], i4[::1], i8, i8)")
def add_differences(
    local: Float32, root: Float32, difference: Float32, age: Float32, difference_rows: Int32, start: int, stop: int
) -> None:
    """Add the remaining differences to a block of dancers: rotations `local` and hips `root`.

    `difference` (A, J + 1, 7), the last row for the hips' translation; `age` (A,) [s] since each dancer's cut;
    `difference_rows` (joints,) the row of each joint of `local`. With an age of LONGEST nothing changes.
    """
    left, joints = np.empty((3, BLOCK), np.float32), local.shape[0]
    for j in range(joints + 1):
        _remaining(difference, age, difference_rows[j] if j < joints else difference.shape[1] - 1, left, start, stop)
        if j == joints:
            break
        for i in range(BLOCK):
            rx, ry, rz = left[0, i], left[1, i], left[2, i]
            s = _QUARTER * (rx * rx + ry * ry + rz * rz)  # half the angle, squared
            aw = _ONE + s * (_C2 + s * (_C4 + s * (_C6 + s * (_C8 + s * (_C10 + s * _C12)))))
            part = _HALF * (_ONE + s * (_S3 + s * (_S5 + s * (_S7 + s * (_S9 + s * _S11)))))
            ax, ay, az = part * rx, part * ry, part * rz
            w, x, y, z = local[j, 0, i], local[j, 1, i], local[j, 2, i], local[j, 3, i]
            local[j, 0, i] = aw * w - ax * x - ay * y - az * z
            local[j, 1, i] = aw * x + ax * w + ay * z - az * y
            local[j, 2, i] = aw * y - ax * z + ay * w + az * x
            local[j, 3, i] = aw * z + ax * y - ay * x + az * w
    for c in range(3):
        for i in range(BLOCK):
            root[c, i] += left[c, i]


@kernel("void(f8[::1], f4[:,::1], i8, i8)")
def _local_rotation(out: Float64, world: Float32, joint: int, parent: int) -> None:
    """Write the rotation of `joint` relative to its parent (the stage if parent is -1) to out (4,)."""
    bw, bx, by, bz = world[joint, 0], world[joint, 1], world[joint, 2], world[joint, 3]
    aw, ax, ay, az = 1.0, 0.0, 0.0, 0.0
    if parent >= 0:
        aw, ax, ay, az = world[parent, 0], -world[parent, 1], -world[parent, 2], -world[parent, 3]
    out[0] = aw * bw - ax * bx - ay * by - az * bz
    out[1] = aw * bx + ax * bw + ay * bz - az * by
    out[2] = aw * by - ax * bz + ay * bw + az * bx
    out[3] = aw * bz + ax * by - ay * bx + az * bw


@kernel("void(f8[::1], f8[::1], f8[::1])")
def _rotation_difference(out: Float64, one: Float64, other: Float64) -> None:
    """Write the rotation from `other` to `one`, both relative to the parent: one times other's inverse."""
    aw, ax, ay, az = one[0], one[1], one[2], one[3]
    bw, bx, by, bz = other[0], -other[1], -other[2], -other[3]
    out[0] = aw * bw - ax * bx - ay * by - az * bz
    out[1] = aw * bx + ax * bw + ay * bz - az * by
    out[2] = aw * by - ax * bz + ay * bw + az * bx
    out[3] = aw * bz + ax * by - ay * bx + az * bw


@inline_kernel
def _negate(q: Float64) -> None:
    for c in range(4):
        q[c] = -q[c]


@kernel("f8(f8[::1])")
def _vector_scale(q: Float64) -> float:
    """Return the factor from q's vector part to the rotation vector [rad]; up to a whole turn, by q's sign."""
    size = math.sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    if size < 1e-9:
        return 2.0 if q[0] >= 0.0 else -2.0
    return 2.0 * math.atan2(size, q[0]) / size


@kernel("f8(f4[::1])")
def fade_time(row: Float32) -> float:
    """Return the fade time [s] of a difference with the offset and speed in `row` (7,)."""
    size, towards = 0.0, 0.0
    for c in range(3):
        size += row[c] * row[c]
        towards -= row[c] * row[3 + c]
    if towards <= 0.0:
        return MAX_FADE_TIME
    return min(max(2.5 * size / towards, MIN_FADE_TIME), MAX_FADE_TIME)  # 2.5 |x0| / (speed towards 0)


@kernel("void(f4[:,:,::1], i4[::1], f4[:,:,:,::1], f4[:,:,:,::1], f4[:,:,:,::1], f4[:,:,:,::1], i4[::1], f8)")
def record_difference(
    difference: Float32, rows: Int32,
    before: Float32, before_position: Float32, after: Float32, after_position: Float32,
    parents: Int32, dt: float,
) -> None:  # fmt: skip
    """Record the pose differences of a cut of the dancers `rows` (n,), and their speeds.

    `before` and `after` (2, n, J, 4): world rotations of the old and the new motion, [0] at the cut and [1] `dt` [s]
    before it (after it if `dt` is negative); with `_position` (2, n, J, 3) [m].
    """
    old, new = np.empty(4), np.empty(4)
    now, then = np.empty(4), np.empty(4)
    joints = parents.shape[0]
    for k in range(rows.shape[0]):
        n = rows[k]
        for j in range(joints):
            _local_rotation(old, before[0, k], j, parents[j])
            _local_rotation(new, after[0, k], j, parents[j])
            _rotation_difference(now, old, new)
            _local_rotation(old, before[1, k], j, parents[j])
            _local_rotation(new, after[1, k], j, parents[j])
            _rotation_difference(then, old, new)
            if now[0] < 0.0:
                _negate(now)
            if now[0] * then[0] + now[1] * then[1] + now[2] * then[2] + now[3] * then[3] < 0.0:
                _negate(then)
            scale, scale_then = _vector_scale(now), _vector_scale(then)
            for c in range(3):
                difference[n, j, c] = scale * now[1 + c]
                difference[n, j, 3 + c] = (scale * now[1 + c] - scale_then * then[1 + c]) / dt
            difference[n, j, DURATION] = fade_time(difference[n, j])
        for c in range(3):
            away = before_position[0, k, 0, c] - after_position[0, k, 0, c]
            difference[n, joints, c] = away
            difference[n, joints, 3 + c] = (away - (before_position[1, k, 0, c] - after_position[1, k, 0, c])) / dt
        difference[n, joints, DURATION] = fade_time(difference[n, joints])


@kernel("b1(f4[::1], f8[::1], f8)")
def update_ages(age: Float32, cut_time: Float64, time: float) -> bool:
    """Set `age` (A,) [s] to the time since the cuts at `cut_time` (A,) [s], at most LONGEST; return whether any is
    less."""
    young = False
    for n in range(age.shape[0]):
        age[n] = min(max(time - cut_time[n], 0.0), MAX_FADE_TIME)
        young |= age[n] < np.float32(MAX_FADE_TIME)
    return young
