"""Neighbour clearance: draws arms of near dancers back towards their own bodies, where they come together.

The shortest way between two crossing arms changes sides as they cross. So arms are drawn back along the line between the
two bodies instead, which way is continuous: both by half of what they overlap along it, with a weight that grows as they
near. Hands are kept out of another's trunk in the same way. There is no state.

Pairs are found by a sweep over the dancers, sorted by the left edge of the box that an arm and the trunk fill.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.pose.arm_clearance_kernels import HIPS, NECK, soft
from live.motion.pose.hand_hold_kernels import PALM

Float32 = npt.NDArray[np.float32]
Bool = npt.NDArray[np.bool_]
Int32 = npt.NDArray[np.int32]

BETWEEN_ARMS: Any = np.float32(0.08)
"""Gap [m] that is left along the line between two bodies where arms of both come together."""
TO_TRUNK: Any = np.float32(0.17)
"""Arms stay this far [m] from the middle of another's trunk along that line."""
NEAR_ARM, FAR_ARM = np.float32(0.08), np.float32(0.26)
"""Arms nearer to each other than NEAR_ARM [m] are drawn back fully, those farther than FAR_ARM not at all."""
NEAR_TRUNK, FAR_TRUNK = np.float32(0.15), np.float32(0.33)
"""The same for the distance of an arm to the line between another's hips and neck [m]."""
KEPT: Any = np.float32(0.14)
"""An arm is not drawn back nearer to the own trunk's middle than this [m]."""
SAME_PLACE: Any = np.float32(0.05)
"""Bodies nearer to each other than this [m] have no line between them."""
_TRUNK_BOX: Any = np.float32(FAR_TRUNK - 0.5 * FAR_ARM)
_PAD: Any = np.float32(0.5 * FAR_ARM)
SHOULDER, ELBOW, WRIST, PALM_POINT, TRUNK_MIDDLE, TRUNK_LOW, TRUNK_HIGH, POINTS = 0, 1, 2, 3, 8, 9, 10, 11
"""Points of a dancer: four of the left arm, four of the right one, three of the trunk."""
_LEFT, _RIGHT, _BACK, _FRONT = range(4)
_MARGIN: Any = np.float32(0.02)
_ZERO: Any = np.float32(0.0)
_HALF: Any = np.float32(0.5)
_ONE: Any = np.float32(1.0)
_TWO: Any = np.float32(2.0)
_THREE: Any = np.float32(3.0)
_TINY: Any = np.float32(1e-12)


@inline_kernel
def _smooth(t: Any) -> Any:
    """Smoothstep: 0 below 0, 1 above 1, zero slope at both."""
    t = min(max(t, _ZERO), _ONE)
    return t * t * (_THREE - _TWO * t)


@kernel("f4(f4[:,::1], i8, i8, f4[:,::1], i8, i8)")
def segment_distance(points: Float32, a: int, b: int, others: Float32, c: int, d: int) -> Any:
    """Return the distance [m] between the segments a-b of `points` and c-d of `others` (Ericson, "Real-Time Collision
    Detection", 2005, section 5.1.9)."""
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = others[d, 0] - others[c, 0], others[d, 1] - others[c, 1], others[d, 2] - others[c, 2]
    wx, wy, wz = points[a, 0] - others[c, 0], points[a, 1] - others[c, 1], points[a, 2] - others[c, 2]
    uu, vv = max(ux * ux + uy * uy + uz * uz, _TINY), max(vx * vx + vy * vy + vz * vz, _TINY)
    uv = ux * vx + uy * vy + uz * vz
    uw, vw = ux * wx + uy * wy + uz * wz, vx * wx + vy * wy + vz * wz
    s = min(max((uv * vw - uw * vv) / max(uu * vv - uv * uv, _TINY), _ZERO), _ONE)
    t = min(max((uv * s + vw) / vv, _ZERO), _ONE)
    s = min(max((uv * t - uw) / uu, _ZERO), _ONE)
    x, y, z = wx + s * ux - t * vx, wy + s * uy - t * vy, wz + s * uz - t * vz
    return np.float32(math.sqrt(x * x + y * y + z * z))


@inline_kernel
def _find_points(points: Float32, box: Float32, position: Float32, rotation: Float32, trunk: Int32, arms: Int32) -> None:
    """Compute the points of all dancers, and the box on the floor that they fill, by half of the farthest distance at
    which others matter larger."""
    for i in range(len(position)):
        for side in range(2):
            hand = arms[side, 2]
            w, x, y, z = rotation[i, hand, 0], rotation[i, hand, 1], rotation[i, hand, 2], rotation[i, hand, 3]
            palm = PALM if side == 0 else -PALM
            for k in range(3):
                for c in range(3):
                    points[i, 4 * side + k, c] = position[i, arms[side, k], c]
            points[i, 4 * side + 3, 0] = position[i, hand, 0] + palm * (_ONE - _TWO * (y * y + z * z))
            points[i, 4 * side + 3, 1] = position[i, hand, 1] + palm * _TWO * (x * y + w * z)
            points[i, 4 * side + 3, 2] = position[i, hand, 2] + palm * _TWO * (x * z - w * y)
        for c in range(3):
            low, high = position[i, trunk[HIPS], c], position[i, trunk[NECK], c]
            points[i, TRUNK_LOW, c], points[i, TRUNK_HIGH, c] = low, high
            points[i, TRUNK_MIDDLE, c] = _HALF * (low + high)
        x, z = points[i, TRUNK_MIDDLE, 0], points[i, TRUNK_MIDDLE, 2]
        left, right, back, front = x - _TRUNK_BOX, x + _TRUNK_BOX, z - _TRUNK_BOX, z + _TRUNK_BOX
        for k in range(8):
            x, z = points[i, k, 0], points[i, k, 2]
            left, right, back, front = min(left, x), max(right, x), min(back, z), max(front, z)
        box[i, _LEFT], box[i, _RIGHT] = left - _PAD, right + _PAD
        box[i, _BACK], box[i, _FRONT] = back - _PAD, front + _PAD


@kernel("f4(f4[:,::1], i8, f4[:,::1], i8)")
def _arm_distance(one: Float32, a: int, other: Float32, b: int) -> Any:
    """Return the distance [m] between the arms that begin at the points `a` and `b`, from shoulder to palm."""
    found = segment_distance(one, a + 1, a + 2, other, b + 1, b + 2)
    for m in range(3):
        for n in range(3):
            if m + n != 0 and not (m == 1 and n == 1):
                found = min(found, segment_distance(one, a + m, a + m + 1, other, b + n, b + n + 1))
    return found


@kernel("void(f4[:,:,::1], i8, i8, f4[::1], f4[:,::1], b1, f4, f4[:,:,:,::1], f4[:,:,::1])")
def _draw_back(
    points: Float32, i: int, j: int, share: Float32, held: Float32, couple: bool, apart_share: Any, drawn: Float32,
    wanted: Float32,
) -> None:  # fmt: skip
    """Add to `drawn` what the dancers `i` and `j` have to draw back from each other, by the share `apart_share`;
    `wanted` (2, 2, 2) is scratch."""
    one, other = points[i], points[j]
    nx, nz = other[TRUNK_MIDDLE, 0] - one[TRUNK_MIDDLE, 0], other[TRUNK_MIDDLE, 2] - one[TRUNK_MIDDLE, 2]
    apart = math.sqrt(nx * nx + nz * nz)
    if apart < SAME_PLACE:
        return
    nx, nz = nx / apart, nz / apart
    for side in range(2):  # wanted: how far each arm extends towards the other body [m], and by how much it draws back
        wanted[0, side, 0] = wanted[1, side, 0] = _ZERO
        wanted[0, side, 1] = wanted[1, side, 1] = _ZERO
        for k in range(4 * side + 1, 4 * side + 4):
            reach = (one[k, 0] - one[TRUNK_MIDDLE, 0]) * nx + (one[k, 2] - one[TRUNK_MIDDLE, 2]) * nz
            wanted[0, side, 0] = max(wanted[0, side, 0], reach)
            reach = (other[TRUNK_MIDDLE, 0] - other[k, 0]) * nx + (other[TRUNK_MIDDLE, 2] - other[k, 2]) * nz
            wanted[1, side, 0] = max(wanted[1, side, 0], reach)
    for a in range(2):
        for b in range(2):
            overlap = wanted[0, a, 0] + wanted[1, b, 0] + BETWEEN_ARMS - apart
            if overlap <= -_MARGIN:
                continue
            free, free_other = _ONE - held[i, a], _ONE - held[j, b]
            mine, others = apart_share * share[i] * free, apart_share * share[j] * free_other
            if couple:
                mine, others = mine * free_other, others * free
            if mine + others <= _ZERO:
                continue
            near = _arm_distance(one, 4 * a, other, 4 * b)
            push = _smooth((FAR_ARM - near) / (FAR_ARM - NEAR_ARM)) * soft(overlap) / max(mine + others, _ONE)
            wanted[0, a, 1] = max(wanted[0, a, 1], push * mine)
            wanted[1, b, 1] = max(wanted[1, b, 1], push * others)
    for who in range(2):
        n, sign = (i, _ONE) if who == 0 else (j, -_ONE)
        arm, body = (one, other) if who == 0 else (other, one)
        for side in range(2):
            free = apart_share * share[n] * (_ONE - held[n, side])
            overlap = wanted[who, side, 0] + TO_TRUNK - apart
            if overlap > -_MARGIN and free > _ZERO:
                k = 4 * side
                near = segment_distance(arm, k + 2, k + 3, body, TRUNK_LOW, TRUNK_HIGH)
                near = min(near, segment_distance(arm, k + 1, k + 2, body, TRUNK_LOW, TRUNK_HIGH))
                push = free * _smooth((FAR_TRUNK - near) / (FAR_TRUNK - NEAR_TRUNK)) * soft(overlap)
                wanted[who, side, 1] = max(wanted[who, side, 1], push)
            if wanted[who, side, 1] <= _ZERO:
                continue
            limit = max(wanted[who, side, 0] - wanted[who, side, 1], KEPT)
            for k in range(1, 4):
                x = arm[4 * side + k, 0] - arm[TRUNK_MIDDLE, 0]
                z = arm[4 * side + k, 2] - arm[TRUNK_MIDDLE, 2]
                wanted[who, side, 1] = max(sign * (x * nx + z * nz) - limit, _ZERO)
                if k == ELBOW:
                    drawn[n, side, 0, 0] -= sign * wanted[who, side, 1] * nx
                    drawn[n, side, 0, 2] -= sign * wanted[who, side, 1] * nz
                elif k == WRIST:
                    reach = wanted[who, side, 1]
                else:
                    reach = max(reach, wanted[who, side, 1])
            drawn[n, side, 1, 0] -= sign * reach * nx
            drawn[n, side, 1, 2] -= sign * reach * nz


@kernel(
    "void(f4[:,:,::1], f4[:,:,::1], f4[:,:,:,::1], f4[::1], f4[:,::1], i4[::1], f4[::1], b1[::1], i4[::1], i4[:,::1])"
)
def draw_back_arms(
    position: Float32, rotation: Float32, drawn: Float32, share: Float32, held: Float32, partner: Int32,
    together: Float32, visible: Bool, trunk: Int32, arms: Int32,
) -> None:  # fmt: skip
    """Compute how elbows and wrists of all dancers draw back from others, `drawn` (A, 2, 2, 3) [m], as for
    `clear_arms`.

    `share` (A,), `held` (A, 2), `partner` (A,), `together` (A,) as in `HeldArms`: arms in a hold may touch the partner,
    and all arms of dancers together. `visible` (A,): others neither draw back nor make anyone do so.
    """
    count = len(position)
    points, box = np.empty((count, POINTS, 3), np.float32), np.empty((count, 4), np.float32)
    wanted = np.empty((2, 2, 2), np.float32)
    drawn[:] = _ZERO
    _find_points(points, box, position, rotation, trunk, arms)
    order = np.argsort(box[:, _LEFT])
    for m in range(count):
        i = order[m]
        if not visible[i]:
            continue
        for n in range(m + 1, count):
            j = order[n]
            if box[j, _LEFT] > box[i, _RIGHT]:
                break
            if visible[j] and box[j, _BACK] <= box[i, _FRONT] and box[i, _BACK] <= box[j, _FRONT]:
                apart = _ONE
                if partner[i] == j:
                    apart -= together[i]
                if partner[j] == i:
                    apart = min(apart, _ONE - together[j])
                couple = partner[i] == j or partner[j] == i
                if apart > _ZERO:
                    _draw_back(points, i, j, share, held, couple, apart, drawn, wanted)
