"""Neighbour clearance: draws arms of near dancers back towards their own bodies, where they come together.

The shortest way between two crossing arms changes sides as they cross. So arms are drawn back along the line between the
two bodies instead, which way is continuous: both by half of what they overlap along it, with a weight that grows as they
near. Hands are kept out of another's trunk in the same way. There is no state.

Pairs are found in a grid, by the boxes that trunk and arms fill on the floor.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.pose.trunk_clearance_kernels import HIPS, MARGIN, NECK, soft
from live.motion.pose.hand_hold_kernels import PALM

Float32 = npt.NDArray[np.float32]
Bool = npt.NDArray[np.bool_]
Int32 = npt.NDArray[np.int32]

BETWEEN_ARMS: Any = np.float32(0.08)
"""Gap [m] that is left along the line between two bodies where arms of both come together."""
TO_TRUNK: Any = np.float32(0.17)
"""Arms stay this far [m] from the middle of another's trunk along that line."""
NEAR_ARM, FAR_ARM = np.float32(0.08), np.float32(0.45)
"""Arms nearer to each other than NEAR_ARM [m] are drawn back fully, those farther than FAR_ARM not at all."""
NEAR_TRUNK, FAR_TRUNK = np.float32(0.15), np.float32(0.5)
"""The same for the distance of an arm to the line between another's hips and neck [m]."""
KEPT: Any = np.float32(0.14)
"""An arm is not drawn back nearer to the own trunk's middle than this [m]."""
ROUNDED: Any = np.float32(0.06)
"""Points are drawn back from this far [m] before the limit at most, and wholly from as far behind it."""
RAISED: Any = np.float32(0.4)
"""An elbow that is drawn back also sinks as far, so that the upper arm's length has room; the higher it is, the less, and
from this far above the shoulder [m] on it rises instead. So does a wrist, ..."""
FOLDED: Any = np.float32(0.3)
"""... but half as far when it is drawn back by this [m], less before: an arm that has far to go is lowered, not folded."""
SAME_PLACE: Any = np.float32(0.05)
"""Bodies nearer to each other than this [m] have no line between them."""
BOX_PAD: Any = np.float32(0.5 * FAR_ARM + 0.1)
"""A dancer's box on the floor is this much larger than the arms [m]: half of the way at which others matter, and as much
as an arm is pushed out of the own trunk ..."""
TRUNK_BOX: Any = np.float32(FAR_TRUNK - 0.5 * FAR_ARM)
"""... and reaches at least this far from hips and neck, with the pad besides [m]."""
LEAST_CELL: Any = np.float32(0.5)
"""Least size [m] of the cells of the grid."""
LEFT, RIGHT, BACK, FRONT = range(4)
"""Rows of `box`."""
SHOULDER, ELBOW, WRIST, PALM_POINT, TRUNK_MIDDLE, TRUNK_LOW, TRUNK_HIGH, POINTS = 0, 1, 2, 3, 8, 9, 10, 11
"""Points of a dancer: four of the left arm, four of the right one, three of the trunk."""
_ZERO: Any = np.float32(0.0)
_HALF: Any = np.float32(0.5)
_ONE: Any = np.float32(1.0)
_TWO: Any = np.float32(2.0)
_THREE: Any = np.float32(3.0)
_TINY: Any = np.float32(1e-12)
_FAR: Any = np.float32(1e6)


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
def _read_points(points: Float32, position: Float32, rotation: Float32, i: int, trunk: Int32, arms: Int32) -> None:
    """Copy the points of dancer `i`."""
    for side in range(2):
        hand = arms[side, 2]
        w, x, y, z = rotation[i, hand, 0], rotation[i, hand, 1], rotation[i, hand, 2], rotation[i, hand, 3]
        palm = PALM if side == 0 else -PALM
        for k in range(3):
            for c in range(3):
                points[4 * side + k, c] = position[i, arms[side, k], c]
        points[4 * side + 3, 0] = position[i, hand, 0] + palm * (_ONE - _TWO * (y * y + z * z))
        points[4 * side + 3, 1] = position[i, hand, 1] + palm * _TWO * (x * y + w * z)
        points[4 * side + 3, 2] = position[i, hand, 2] + palm * _TWO * (x * z - w * y)
    for c in range(3):
        low, high = position[i, trunk[HIPS], c], position[i, trunk[NECK], c]
        points[TRUNK_LOW, c], points[TRUNK_HIGH, c], points[TRUNK_MIDDLE, c] = low, high, _HALF * (low + high)


@kernel("f4(f4[:,::1], i8, f4[:,::1], i8)")
def _arm_distance(one: Float32, a: int, other: Float32, b: int) -> Any:
    """Return the distance [m] between the arms that begin at the points `a` and `b`, from shoulder to palm."""
    found = segment_distance(one, a + 1, a + 2, other, b + 1, b + 2)
    for m in range(3):
        for n in range(3):
            if m + n != 0 and not (m == 1 and n == 1):
                found = min(found, segment_distance(one, a + m, a + m + 1, other, b + n, b + n + 1))
    return found


@inline_kernel
def _held(held: Float32, i: int, side: int) -> Any:
    """Return how far a hand is in a hold; with an empty `held` nobody holds hands."""
    return held[i, side] if len(held) else _ZERO


@inline_kernel
def _way_up(arm: Float32, first: int, k: int) -> Any:
    """Return whether the point `k` of the arm that begins at `first` has room upwards, 1, or rather downwards, -1."""
    raised = arm[first + k, 1] - arm[first + SHOULDER, 1]
    return _TWO * _smooth(raised / RAISED) - _ONE


@kernel("void(f4[:,::1], f4[:,::1], i8, i8, f4[::1], f4[:,::1], b1, f4, f4[:,:,::1], f4[:,:,::1])")
def _draw_back(
    one: Float32, other: Float32, i: int, j: int, amount: Float32, held: Float32, couple: bool, apart_share: Any,
    drawn: Float32, wanted: Float32,
) -> None:  # fmt: skip
    """Add to `drawn` (2 A, 2, 3) what the dancers `i` and `j`, at the points `one` and `other`, draw back from each
    other, by the share `apart_share`. `wanted` (2, 2, 2) is scratch."""
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
            if overlap <= -MARGIN:
                continue
            mine, others = apart_share * amount[2 * i + a], apart_share * amount[2 * j + b]
            if couple:
                mine, others = mine * (_ONE - _held(held, j, b)), others * (_ONE - _held(held, i, a))
            if mine + others <= _ZERO:
                continue
            near = _arm_distance(one, 4 * a, other, 4 * b)
            push = _smooth((FAR_ARM - near) / (FAR_ARM - NEAR_ARM)) * soft(overlap, MARGIN) / max(mine + others, _ONE)
            wanted[0, a, 1] += (push * mine) ** 4
            wanted[1, b, 1] += (push * others) ** 4
    for who in range(2):
        n, sign = (i, _ONE) if who == 0 else (j, -_ONE)
        arm, body = (one, other) if who == 0 else (other, one)
        for side in range(2):
            free = apart_share * amount[2 * n + side]
            overlap = wanted[who, side, 0] + TO_TRUNK - apart
            if overlap > -MARGIN and free > _ZERO:
                k = 4 * side
                near = segment_distance(arm, k + 2, k + 3, body, TRUNK_LOW, TRUNK_HIGH)
                near = min(near, segment_distance(arm, k + 1, k + 2, body, TRUNK_LOW, TRUNK_HIGH))
                push = free * _smooth((FAR_TRUNK - near) / (FAR_TRUNK - NEAR_TRUNK)) * soft(overlap, MARGIN)
                wanted[who, side, 1] += push**4
            if wanted[who, side, 1] <= _ZERO:
                continue
            wish = math.sqrt(math.sqrt(wanted[who, side, 1]))  # about the largest, but smooth where two are the same
            limit = max(wanted[who, side, 0] - wish, KEPT)
            round_off = min(_HALF * wish, ROUNDED)
            reach = _ZERO
            for k in range(1, 4):
                x = arm[4 * side + k, 0] - arm[TRUNK_MIDDLE, 0]
                z = arm[4 * side + k, 2] - arm[TRUNK_MIDDLE, 2]
                over = soft(sign * (x * nx + z * nz) - limit, round_off)
                if k == ELBOW:
                    drawn[2 * n + side, 0, 0] -= sign * over * nx
                    drawn[2 * n + side, 0, 1] += over * _way_up(arm, 4 * side, ELBOW)
                    drawn[2 * n + side, 0, 2] -= sign * over * nz
                else:
                    reach = max(reach, over)
            drawn[2 * n + side, 1, 0] -= sign * reach * nx
            drawn[2 * n + side, 1, 1] += reach * reach / (reach + FOLDED) * _way_up(arm, 4 * side, WRIST)
            drawn[2 * n + side, 1, 2] -= sign * reach * nz


@inline_kernel
def _cell(x: Any, corner: Any, size: Any, cells: int) -> Any:
    """Return the column (or row) of the grid that contains `x` [m]; beyond the last one it is the last one."""
    return np.int64(min(max(_ZERO, (x - corner) / size), np.float32(cells - 1)))


@kernel("i4[:,::1](f4[:,::1], b1[::1])")
def find_pairs(box: Float32, visible: Bool) -> Int32:
    """Return all pairs of `visible` dancers (A,) whose boxes overlap, (P, 2), in an order that depends on places only.

    `box` (4, A): LEFT, RIGHT, BACK and FRONT edge of what each dancer fills on the floor [m]. A counting sort into a grid
    as coarse as the largest box: whoever meets is in the same cell or in one beside it.
    """
    count, present = box.shape[1], 0
    corner_x, corner_z, end_x, end_z, size = _FAR, _FAR, -_FAR, -_FAR, LEAST_CELL
    for i in range(count):
        if visible[i]:
            corner_x, end_x = min(corner_x, box[LEFT, i]), max(end_x, box[LEFT, i])
            corner_z, end_z = min(corner_z, box[BACK, i]), max(end_z, box[BACK, i])
            size = max(size, max(box[RIGHT, i] - box[LEFT, i], box[FRONT, i] - box[BACK, i]))
            present += 1
    most = np.float32(2.0 * math.sqrt(float(count)) + 2.0)
    columns = np.int64(min(max(_ONE, (end_x - corner_x) / size + _ONE), most))
    rows = np.int64(min(max(_ONE, (end_z - corner_z) / size + _ONE), most))
    start, cell = np.zeros(columns * rows + 2, np.int32), np.empty(count, np.int32)
    for i in range(count):
        if visible[i]:
            row = _cell(box[BACK, i], corner_z, size, rows)
            cell[i] = row * columns + _cell(box[LEFT, i], corner_x, size, columns)
            start[cell[i] + 2] += 1
    for k in range(columns * rows):
        start[k + 2] += start[k + 1]
    order, edges = np.empty(present, np.int32), np.empty((present, 4), np.float32)
    for i in range(count):
        if visible[i]:
            m = start[cell[i] + 1]
            start[cell[i] + 1] += 1
            order[m] = i
            for k in range(4):
                edges[m, k] = box[k, i]
    pairs, found = np.empty((2 * count, 2), np.int32), 0
    for m in range(present):
        row, column = cell[order[m]] // columns, cell[order[m]] % columns
        first_column, last_column = max(column - 1, 0), min(column + 1, columns - 1)
        for k in range(row, min(row + 2, rows)):
            first = m + 1 if k == row else start[k * columns + first_column]
            for n in range(first, start[k * columns + last_column + 1]):
                if (
                    edges[n, LEFT] <= edges[m, RIGHT] and edges[m, LEFT] <= edges[n, RIGHT]
                    and edges[n, BACK] <= edges[m, FRONT] and edges[m, BACK] <= edges[n, FRONT]
                ):  # fmt: skip
                    if found == len(pairs):
                        more = np.empty((2 * len(pairs), 2), np.int32)
                        more[:found] = pairs
                        pairs = more
                    pairs[found, 0], pairs[found, 1] = order[m], order[n]
                    found += 1
    return pairs[:found]


@kernel(
    "void(f4[:,:,::1], f4[:,:,::1], f4[:,:,::1], i4[:,::1], f4[::1], f4[:,::1], i4[::1], f4[::1], i4[::1], i4[:,::1])"
)
def draw_back_arms(
    position: Float32, rotation: Float32, drawn: Float32, pairs: Int32, amount: Float32, held: Float32, partner: Int32,
    together: Float32, trunk: Int32, arms: Int32,
) -> None:  # fmt: skip
    """Compute how elbows and wrists draw back where the dancers of `pairs` (P, 2) come together, `drawn` (2 A, 2, 3)
    [m], as for `move_arms`.

    `amount` (2 A,): how far each arm does so, 0 to 1. `held`, `partner` and `together` as in `HeldArms`, or all empty:
    arms in a hold may touch the partner, and all arms of dancers together.
    """
    one, other = np.empty((POINTS, 3), np.float32), np.empty((POINTS, 3), np.float32)
    wanted = np.empty((2, 2, 2), np.float32)
    drawn[:] = _ZERO
    last = -1
    for n in range(len(pairs)):
        i, j = pairs[n, 0], pairs[n, 1]
        apart, couple = _ONE, False
        if len(partner):
            couple = partner[i] == j or partner[j] == i
            apart -= together[i] if partner[i] == j else _ZERO
            apart = min(apart, _ONE - together[j]) if partner[j] == i else apart
        if apart <= _ZERO:
            continue
        if i != last:
            _read_points(one, position, rotation, i, trunk, arms)
            last = i
        _read_points(other, position, rotation, j, trunk, arms)
        _draw_back(one, other, i, j, amount, held, couple, apart, drawn, wanted)
