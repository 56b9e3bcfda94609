"""Kernels of joints and limbs for garments: gathered by lanes, between two ticks, placed in the world; skin.

Garments of one pattern on LANES dancers are a *block*: every number is a row of LANES dancers (structure of arrays), so
that the compiler vectorizes each loop over lanes. Joints are (JOINT_ROWS, J, LANES), limbs (LIMB_ROWS, K, LANES).
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

LANES = 8
"""Dancers in a block."""
MIDDLE, AXES, SIDES, FRONTS, BACKS, CAPS, LENGTH, PER_LENGTH, BOUND = 0, 3, 12, 16, 20, 24, 26, 27, 28
"""Rows of a limb: middle of its start, its three axes (sides, along, front), polynomials of the inverse half-widths,
inverse reach of both ends, length and its inverse, and square of the distance from the line within which all touches
are."""
LIMB_ROWS = 29
PLACE, TURN = 0, 3
"""Rows of a joint: its position, its rotation matrix by rows."""
JOINT_ROWS = 12
_ZERO: Any = np.float32(0.0)
_HALF: Any = np.float32(0.5)
_ONE: Any = np.float32(1.0)
_TWO: Any = np.float32(2.0)
_THREE: Any = np.float32(3.0)
_FOUR: Any = np.float32(4.0)
_TINY: Any = np.float32(1e-12)
_FLATTER: Any = np.float32(1.12)  # inverse half-width of what is between legs, relative to theirs
_LEAST: Any = np.float32(0.02)


@kernel("void(f4[:,:,::1], f4[:,:,::1], i4[::1], i4[::1], f4[:,:,::1])")
def gather_joints(position: Float32, rotation: Float32, rows: Int32, joints: Int32, out: Float32) -> None:
    """Copy position and rotation of `joints` (J,) of the dancers `rows` (LANES,) into `out` (7, J, LANES)."""
    for j in range(joints.shape[0]):
        joint = joints[j]
        for i in range(LANES):
            a = rows[i]
            for c in range(3):
                out[c, j, i] = position[a, joint, c]
            for c in range(4):
                out[3 + c, j, i] = rotation[a, joint, c]


@kernel("void(f4[:,:,::1], f4[:,:,::1], f4, f4[:,:,::1])")
def interpolate_joints(before: Float32, now: Float32, share: float, out: Float32) -> None:
    """Compute the joints `share` of the way from `before` to `now`, both (7, J, LANES): out (JOINT_ROWS, J, LANES)."""
    n = before.shape[1] * LANES
    b, a, o = now.reshape((7, n)), before.reshape((7, n)), out.reshape((JOINT_ROWS, n))
    for c in range(3):
        first, last, to = a[c], b[c], o[c]
        for i in range(n):
            to[i] = first[i] + share * (last[i] - first[i])
    aw, ax, ay, az, bw, bx, by, bz = a[3], a[4], a[5], a[6], b[3], b[4], b[5], b[6]
    t = np.empty((4, n), np.float32)
    for i in range(n):
        dot = aw[i] * bw[i] + ax[i] * bx[i] + ay[i] * by[i] + az[i] * bz[i]
        to_b = share if dot >= _ZERO else -share
        w, x, y, z = aw[i] * (_ONE - share) + bw[i] * to_b, ax[i] * (_ONE - share) + bx[i] * to_b, _ZERO, _ZERO
        y = ay[i] * (_ONE - share) + by[i] * to_b
        z = az[i] * (_ONE - share) + bz[i] * to_b
        scale = _ONE / math.sqrt(w * w + x * x + y * y + z * z + _TINY)
        t[0, i], t[1, i], t[2, i], t[3, i] = w * scale, x * scale, y * scale, z * scale
    for i in range(n):
        w, x, y, z = t[0, i], t[1, i], t[2, i], t[3, i]
        o[TURN, i] = _ONE - _TWO * (y * y + z * z)
        o[TURN + 1, i] = _TWO * (x * y - w * z)
        o[TURN + 2, i] = _TWO * (x * z + w * y)
        o[TURN + 3, i] = _TWO * (x * y + w * z)
        o[TURN + 4, i] = _ONE - _TWO * (x * x + z * z)
        o[TURN + 5, i] = _TWO * (y * z - w * x)
        o[TURN + 6, i] = _TWO * (x * z - w * y)
        o[TURN + 7, i] = _TWO * (y * z + w * x)
        o[TURN + 8, i] = _ONE - _TWO * (x * x + y * y)


@kernel("void(f4[:,:,::1], i4[::1], f4[:,:,::1], f4[:,:,::1])")
def place_limbs(joints: Float32, limb_joint: Int32, own: Float32, out: Float32) -> None:
    """Place the limbs `own` (LIMB_ROWS, K, LANES), in the axes of their joints, in the world: `out` likewise.

    joints (JOINT_ROWS, J, LANES); limb_joint (K,): index of each limb's joint in it.
    """
    for k in range(limb_joint.shape[0]):
        j = limb_joint[k]
        for row in range(4):
            first = 3 * row
            a, b, c = own[first, k], own[first + 1, k], own[first + 2, k]
            for axis in range(3):
                ta, tb, tc = joints[TURN + 3 * axis, j], joints[TURN + 3 * axis + 1, j], joints[TURN + 3 * axis + 2, j]
                to, middle = out[first + axis, k], joints[PLACE + axis, j]
                if row == 0:
                    for i in range(LANES):
                        to[i] = middle[i] + ta[i] * a[i] + tb[i] * b[i] + tc[i] * c[i]
                else:
                    for i in range(LANES):
                        to[i] = ta[i] * a[i] + tb[i] * b[i] + tc[i] * c[i]
        for row in range(SIDES, LIMB_ROWS):
            for i in range(LANES):
                out[row, k, i] = own[row, k, i]


@kernel("void(f4[:,:,::1], i4[:,::1], f4[:,::1])")
def place_bridges(limbs: Float32, bridges: Int32, work: Float32) -> None:
    """Place limbs between two others: limbs (LIMB_ROWS, K, LANES), bridges (N, 3): the limb, and the two beside it.

    Its line is the middle of theirs; it reaches from one line to the other, and is _FLATTER than they are. work (9,
    LANES).
    """
    for n in range(bridges.shape[0]):
        k, left, right = bridges[n, 0], bridges[n, 1], bridges[n, 2]
        for i in range(LANES):
            wide0 = wide1 = long_ = _ZERO
            for axis in range(3):
                a, b = limbs[MIDDLE + axis, left, i], limbs[MIDDLE + axis, right, i]
                c = a + limbs[AXES + 3 + axis, left, i] * limbs[LENGTH, left, i]
                d = b + limbs[AXES + 3 + axis, right, i] * limbs[LENGTH, right, i]
                limbs[MIDDLE + axis, k, i] = _HALF * (a + b)
                along = _HALF * (c + d - a - b)
                work[axis, i], work[3 + axis, i] = along, (a - b) + (c - d)
                wide0 += (a - b) * (a - b)
                wide1 += (c - d) * (c - d)
                long_ += along * along
            long_ = max(math.sqrt(long_), _LEAST)
            wide0, wide1 = max(_HALF * math.sqrt(wide0), _LEAST), max(_HALF * math.sqrt(wide1), _LEAST)
            dot = size = _ZERO
            for axis in range(3):
                work[axis, i] /= long_
                dot += work[axis, i] * work[3 + axis, i]
            for axis in range(3):
                work[3 + axis, i] -= dot * work[axis, i]
                size += work[3 + axis, i] * work[3 + axis, i]
            size = _ONE / math.sqrt(size + _TINY)
            for axis in range(3):
                work[3 + axis, i] *= size
            for axis in range(3):
                p, q = (axis + 1) % 3, (axis + 2) % 3
                limbs[AXES + axis, k, i], limbs[AXES + 3 + axis, k, i] = work[3 + axis, i], work[axis, i]
                limbs[AXES + 6 + axis, k, i] = work[3 + p, i] * work[q, i] - work[3 + q, i] * work[p, i]
            limbs[LENGTH, k, i], limbs[PER_LENGTH, k, i] = long_, _ONE / long_
            # the inverse of the half-width at both ends and in the middle
            w0, w1, wm = _ONE / wide0, _ONE / wide1, _TWO / (wide0 + wide1)
            limbs[SIDES, k, i], limbs[SIDES + 1, k, i] = w0, _FOUR * wm - w1 - _THREE * w0
            limbs[SIDES + 2, k, i], limbs[SIDES + 3, k, i] = _TWO * (w0 + w1) - _FOUR * wm, _ZERO
            for row in range(4):
                for first in (FRONTS, BACKS):
                    both = limbs[first + row, left, i] + limbs[first + row, right, i]
                    limbs[first + row, k, i] = _FLATTER * _HALF * both
            limbs[CAPS, k, i], limbs[CAPS + 1, k, i] = limbs[CAPS, left, i], limbs[CAPS + 1, left, i]
            bound = max(wide0, wide1) + math.sqrt(limbs[BOUND, left, i])
            limbs[BOUND, k, i] = bound * bound


@kernel("void(f4[:,:,::1], i4[:,::1], f4[:,::1], f4[:,:,::1], i8, f4[:,:,::1])")
def skin_particles(joints: Float32, by: Int32, weight: Float32, rest: Float32, count: int, out: Float32) -> None:
    """Move the first `count` particles as skin: out (3, P, LANES).

    by (P, 2): indices in `joints` (JOINT_ROWS, J, LANES); the second is followed by the share `weight` (P, 2). rest
    (6, P, LANES): places relative to both joints, in their axes in the rest pose. An index of -1 is an upright joint at
    the place of the other.
    """
    for p in range(count):
        first, second, share = by[p, 0], by[p, 1], weight[p, 1]
        for axis in range(3):
            to = out[axis, p]
            a = TURN + 3 * axis
            if second < 0:
                for i in range(LANES):
                    to[i] = (
                        joints[PLACE + axis, first, i]
                        + joints[a, first, i] * rest[0, p, i]
                        + (joints[a + 1, first, i] * rest[1, p, i] + joints[a + 2, first, i] * rest[2, p, i])
                    )
                    to[i] += share * rest[3 + axis, p, i]
            else:
                for i in range(LANES):
                    one = (
                        joints[PLACE + axis, first, i]
                        + joints[a, first, i] * rest[0, p, i]
                        + (joints[a + 1, first, i] * rest[1, p, i] + joints[a + 2, first, i] * rest[2, p, i])
                    )
                    other = (
                        joints[PLACE + axis, second, i]
                        + joints[a, second, i] * rest[3, p, i]
                        + (joints[a + 1, second, i] * rest[4, p, i] + joints[a + 2, second, i] * rest[5, p, i])
                    )
                    to[i] = one + share * (other - one)
