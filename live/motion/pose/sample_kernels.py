"""Sampling, SLERP, placement and forward kinematics in blocks of dancers.

Within a block every number is a row of BLOCK dancers (structure of arrays), so that the compiler vectorizes each loop
over a row: no branches, no float64, no calls inside such a loop. Lanes beyond the last dancer repeat the last one.
`local` is (J, 4, BLOCK): local rotations; `world` is (J, 7, BLOCK): rotations, then positions [m].
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

BLOCK = 32
"""Dancers per block: rows of 128 bytes; all rows of a block fit in the L1/L2 caches."""
_ZERO: Any = np.float32(0.0)
_HALF: Any = np.float32(0.5)
_ONE: Any = np.float32(1.0)
_THREE_HALVES: Any = np.float32(1.5)
_TWO: Any = np.float32(2.0)
_FIVE: Any = np.float32(5.0)
_TINY: Any = np.float32(1e-12)
_TURN = 2.0 * math.pi
_C2, _C4, _C6, _C8, _C10, _C12 = (np.float32((-1) ** (n // 2) / math.factorial(n)) for n in range(2, 14, 2))
_S3, _S5, _S7, _S9, _S11 = (np.float32((-1) ** (n // 2) / math.factorial(n)) for n in range(3, 13, 2))
# Eberly, "A Fast and Accurate Algorithm for Computing SLERP" (2011), 8 terms: 1/(i(2i+1)), i/(2i+1), the last corrected
_MU = 1.85298109240830
_A1, _A2, _A3, _A4, _A5, _A6, _A7 = (np.float32(1.0 / (i * (2 * i + 1))) for i in range(1, 8))
_B1, _B2, _B3, _B4, _B5, _B6, _B7 = (np.float32(i / (2.0 * i + 1.0)) for i in range(1, 8))
_A8, _B8 = np.float32(_MU / (8 * 17)), np.float32(_MU * 8 / 17)


@inline_kernel
def _slerp_weight(t: Any, off: Any) -> Any:
    """Return sin(t a) / sin(a) for cos(a) = 1 + `off`, by Eberly's polynomial: within 1e-5 up to a right angle."""
    s = t * t
    tail = _ONE + (_A7 * s - _B7) * off * (_ONE + (_A8 * s - _B8) * off)
    tail = _ONE + (_A4 * s - _B4) * off * (_ONE + (_A5 * s - _B5) * off * (_ONE + (_A6 * s - _B6) * off * tail))
    return t * (_ONE + (_A1 * s - _B1) * off * (_ONE + (_A2 * s - _B2) * off * (_ONE + (_A3 * s - _B3) * off * tail)))


@inline_kernel
def slerp_rows(target: Float32, other: Float32, share: Float32, first: int, last: int) -> None:
    """SLERP joints first..last-1 of `target` towards `other` by `share` (BLOCK,) (T035, T045).

    The root takes the shorter arc. For the other joints the quaternions' signs decide: clips store those nearest to the
    rest pose, so a joint never rotates through a direction in which it cannot bend, and never changes direction within
    a blend. Beyond a right angle between the quaternions (half a turn of the joint) the chord replaces the arc.
    """
    for j in range(first, last):
        shorter = j == 0
        for i in range(BLOCK):
            aw, ax, ay, az = target[j, 0, i], target[j, 1, i], target[j, 2, i], target[j, 3, i]
            bw, bx, by, bz = other[j, 0, i], other[j, 1, i], other[j, 2, i], other[j, 3, i]
            dot = aw * bw + ax * bx + ay * by + az * bz
            sign = -_ONE if shorter and dot < _ZERO else _ONE
            dot = dot * sign
            off = max(dot, _ZERO) - _ONE
            t = share[i]
            arc = min(max(dot * _FIVE, _ZERO), _ONE)  # 1: the arc, 0: the chord
            a = arc * _slerp_weight(_ONE - t, off) + (_ONE - arc) * (_ONE - t)
            b = sign * (arc * _slerp_weight(t, off) + (_ONE - arc) * t)
            w, x, y, z = a * aw + b * bw, a * ax + b * bx, a * ay + b * by, a * az + b * bz
            scale = _ONE / math.sqrt(max(w * w + x * x + y * y + z * z, _TINY))
            target[j, 0, i] = w * scale
            target[j, 1, i] = x * scale
            target[j, 2, i] = y * scale
            target[j, 3, i] = z * scale


@inline_kernel
def normalize_rows(local: Float32, first: int, last: int) -> None:
    """Normalize the rotations of joints first..last-1; they may be as short as sums of rotations are."""
    for j in range(first, last):
        for i in range(BLOCK):
            w, x, y, z = local[j, 0, i], local[j, 1, i], local[j, 2, i], local[j, 3, i]
            scale = _ONE / math.sqrt(max(w * w + x * x + y * y + z * z, _TINY))
            local[j, 0, i] = w * scale
            local[j, 1, i] = x * scale
            local[j, 2, i] = y * scale
            local[j, 3, i] = z * scale


@inline_kernel
def gather_samples(local: Float32, lanes: Float32, clips: Float32, sample: Float64, start: int, stop: int) -> None:
    """Sample the rotations of the block's dancers at fractional samples, linear and normalized.

    `clips` (S, 4 J) holds each sample's rotations consecutively; `lanes` (BLOCK, 4 J) is scratch: it is read and
    written along the samples, then transposed into rows.
    """
    last = clips.shape[0] - 1
    for i in range(BLOCK):
        at = min(max(sample[min(start + i, stop - 1)], 0.0), float(last))
        low = int(at)
        high = min(low + 1, last)
        t = np.float32(at - low)
        for k in range(clips.shape[1]):
            lanes[i, k] = clips[low, k] + t * (clips[high, k] - clips[low, k])
    for j in range(local.shape[0]):
        for i in range(BLOCK):
            w, x, y, z = lanes[i, 4 * j], lanes[i, 4 * j + 1], lanes[i, 4 * j + 2], lanes[i, 4 * j + 3]
            scale = _THREE_HALVES - _HALF * (w * w + x * x + y * y + z * z)  # one Newton step: the length is nearly 1
            local[j, 0, i] = w * scale
            local[j, 1, i] = x * scale
            local[j, 2, i] = y * scale
            local[j, 3, i] = z * scale


@kernel("void(f4[:,:,::1], f4[:,::1], f8[::1], f4[:,::1], i8, i8, i8, i8, i8)")
def gather_late_arms(
    local: Float32,
    clips: Float32,
    sample: Float64,
    late: Float32,
    row: int,
    first: int,
    last: int,
    start: int,
    stop: int,
) -> None:
    """Sample the joints first..last-1, two arms from the shoulders on, by `row` of `late` (R, A) samples behind the
    body; not if there is no such row.

    The hands are so late, the joints before them less in equal steps: a movement runs along the arm.
    """
    end, count = clips.shape[0] - 1, (last - first) // 2
    for i in range(BLOCK if row < late.shape[0] else 0):
        n = min(start + i, stop - 1)
        if late[row, n] <= _ZERO:
            continue
        for j in range(first, last):
            share = float((j - first) % count + 1) / count
            at = min(max(sample[n] - share * late[row, n], 0.0), float(end))
            low = int(at)
            high, t = min(low + 1, end), np.float32(at - low)
            size = _ZERO
            for c in range(4):
                value = clips[low, 4 * j + c] + t * (clips[high, 4 * j + c] - clips[low, 4 * j + c])
                local[j, c, i] = value
                size += value * value
            scale = _THREE_HALVES - _HALF * size
            for c in range(4):
                local[j, c, i] *= scale


@inline_kernel
def _half_turn(yaw: float) -> tuple[float, float]:
    """Return cosine and sine of half of `yaw` [rad] by their series after removing whole turns; within 1e-7.

    After an odd number of turns both have the other sign, which is the same rotation.
    """
    h: Any = np.float32(0.5 * (yaw - _TURN * math.floor(yaw / _TURN + 0.5)))
    s = h * h
    cosine = _ONE + s * (_C2 + s * (_C4 + s * (_C6 + s * (_C8 + s * (_C10 + s * _C12)))))
    return cosine, h * (_ONE + s * (_S3 + s * (_S5 + s * (_S7 + s * (_S9 + s * _S11)))))


@inline_kernel
def place_root(
    local: Float32, root: Float32, clip_root: Float32, sample: Float64, placement: Float64, start: int, stop: int
) -> None:
    """Compute the hips of the block's dancers at their samples, placed by `placement`: x, z, yaw of path, yaw of
    body."""
    last = clip_root.shape[0] - 1
    at_x, at_z, path, body = np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK)
    for i in range(BLOCK):
        n = min(start + i, stop - 1)
        at = min(max(sample[n], 0.0), float(last))
        low = int(at)
        high = min(low + 1, last)
        t = np.float32(at - low)
        for axis in range(3):
            root[axis, i] = clip_root[low, axis] + t * (clip_root[high, axis] - clip_root[low, axis])
        at_x[i], at_z[i], path[i], body[i] = placement[n, 0], placement[n, 1], placement[n, 2], placement[n, 3]
    for i in range(BLOCK):
        c, s = _half_turn(path[i])
        c, s = c * c - s * s, _TWO * c * s
        x, z = root[0, i], root[2, i]
        root[0, i] = at_x[i] + x * c + z * s
        root[2, i] = at_z[i] + z * c - x * s
        # rotate about +Y last: (c, 0, s, 0) times the clip's rotation
        c, s = _half_turn(body[i])
        w, qx, qy, qz = local[0, 0, i], local[0, 1, i], local[0, 2, i], local[0, 3, i]
        local[0, 0, i] = c * w - s * qy
        local[0, 1, i] = c * qx + s * qz
        local[0, 2, i] = c * qy + s * w
        local[0, 3, i] = c * qz - s * qx


@inline_kernel
def forward_kinematics_rows(world: Float32, local: Float32, root: Float32, offsets: Float32, parents: Int32) -> None:
    """Forward kinematics of a block: B = A + O_B R_A (T164); parents come before their children."""
    for i in range(BLOCK):
        for c in range(4):
            world[0, c, i] = local[0, c, i]
        for c in range(3):
            world[0, 4 + c, i] = root[c, i]
    above = np.empty((7, BLOCK), np.float32)  # a copy, because the compiler cannot know that parent and child differ
    for j in range(1, parents.shape[0]):
        p = parents[j]
        ox, oy, oz = offsets[j, 0], offsets[j, 1], offsets[j, 2]
        for c in range(7):
            for i in range(BLOCK):
                above[c, i] = world[p, c, i]
        for i in range(BLOCK):
            aw, ax, ay, az = above[0, i], above[1, i], above[2, i], above[3, i]
            bw, bx, by, bz = local[j, 0, i], local[j, 1, i], local[j, 2, i], local[j, 3, i]
            world[j, 0, i] = aw * bw - ax * bx - ay * by - az * bz
            world[j, 1, i] = aw * bx + ax * bw + ay * bz - az * by
            world[j, 2, i] = aw * by - ax * bz + ay * bw + az * bx
            world[j, 3, i] = aw * bz + ax * by - ay * bx + az * bw
            tx, ty, tz = _TWO * (ay * oz - az * oy), _TWO * (az * ox - ax * oz), _TWO * (ax * oy - ay * ox)
            world[j, 4, i] = above[4, i] + ox + aw * tx + ay * tz - az * ty
            world[j, 5, i] = above[5, i] + oy + aw * ty + az * tx - ax * tz
            world[j, 6, i] = above[6, i] + oz + aw * tz + ax * ty - ay * tx


@inline_kernel
def write_block(position: Float32, rotation: Float32, world: Float32, start: int, stop: int) -> None:
    """Write the block's joints to the arrays of all dancers, (A, J, 3) and (A, J, 4)."""
    for j in range(world.shape[0]):
        for i in range(stop - start):
            for c in range(4):
                rotation[start + i, j, c] = world[j, c, i]
            for c in range(3):
                position[start + i, j, c] = world[j, 4 + c, i]
