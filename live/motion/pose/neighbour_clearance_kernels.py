"""Neighbour clearance: draws arms of near dancers back towards their own bodies, where they come together.

The shortest way between two crossing arms changes sides as they cross. So arms are drawn back along the line between
the two bodies instead, a way that is continuous: both by half of what they overlap along it, with a weight that grows
as they near. Hands are kept out of another's trunk in the same way. There is no state here: `ArmEasing` has it.

Pairs are found in a grid, by the boxes that trunk and arms fill on the floor.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.pose.body_capsules import ARMS_APART
from live.motion.pose.hand_hold_kernels import PALM
from live.motion.pose.trunk_clearance_kernels import HIPS, NECK, soft

Float32 = npt.NDArray[np.float32]
Bool = npt.NDArray[np.bool_]
Int32 = npt.NDArray[np.int32]

BETWEEN_ARMS: Any = np.float32(ARMS_APART)
"""Gap [m] that is left along the line between two bodies where arms of both come together."""
TO_TRUNK: Any = np.float32(0.15)
"""Arms stay this far [m] from the middle of another's trunk along that line: half a trunk and half a palm."""
OVERLAP_MARGIN: Any = np.float32(0.08)
"""Arms begin to draw back this far [m] before they overlap so, and do so wholly as far behind it."""
NEAR_ARM, FAR_ARM = np.float32(0.08), np.float32(0.45)
"""Arms nearer to each other than NEAR_ARM [m] are drawn back fully, those farther than FAR_ARM not at all. Two arms
pass each other at up to 5 m/s: over a shorter way they would jerk."""
NEAR_TRUNK, FAR_TRUNK = np.float32(0.15), np.float32(0.5)
"""The same for the distance of an arm to the line between another's hips and neck [m]."""
KEPT: Any = np.float32(0.14)
"""An arm is not drawn back nearer to the own trunk's middle than this [m]."""
LEAST_REACH: Any = np.float32(0.22)
"""Nor is a wrist drawn back nearer to its shoulder than this [m], about half an arm: there the elbow would spin."""
REACH_MARGIN: Any = np.float32(0.02)
"""Softness of that [m²]."""
EVENED: Any = np.float32(0.05)
"""Points that extend equally far within this way [m] count as one that extends a little farther."""
RAISED: Any = np.float32(0.4)
"""An elbow that is drawn back also sinks as far, so that the upper arm's length has room; the higher it is, the less,
and from this far above the shoulder [m] on it rises instead. So does a wrist, ..."""
FOLDED: Any = np.float32(0.3)
"""... but half as far when it is drawn back by this [m], less before: an arm with far to go is lowered, not folded."""
SAME_PLACE: Any = np.float32(0.05)
"""Bodies nearer to each other than this [m] have no line between them."""
BOX_PAD: Any = np.float32(0.5 * FAR_ARM + 0.1)
"""A dancer's box on the floor is this much larger than the arms [m]: half of the way at which others matter, and as
much as an arm is pushed out of the own trunk ..."""
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
_FOUR: Any = np.float32(4.0)
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
def _find_extents(along: Float32, one: Float32, other: Float32, nx: Any, nz: Any) -> None:
    """Compute how far elbow, wrist and palm of both dancers are from the own trunk's middle towards the other's [m],
    `along` (2, 2, 4) by dancer, side and point; the first point is the whole arm: about the largest of the three, but
    smooth where two are the same."""
    for who in range(2):
        arm = one if who == 0 else other
        sign = _ONE if who == 0 else -_ONE
        for side in range(2):
            most = _ZERO
            for k in range(1, 4):
                x, z = arm[4 * side + k, 0] - arm[TRUNK_MIDDLE, 0], arm[4 * side + k, 2] - arm[TRUNK_MIDDLE, 2]
                reach = sign * (x * nx + z * nz)
                along[who, side, k] = reach
                same = max(EVENED - abs(most - reach), _ZERO)
                most = max(most, reach) + same * same / (_FOUR * EVENED)
            along[who, side, 0] = most


@inline_kernel
def _add_arm_wishes(
    wish: Float32, along: Float32, one: Float32, other: Float32, apart: Any, free: Float32, open_hands: Float32
) -> None:
    """Add by how much each point has to draw back from the other's arms [m], to the fourth power, to `wish` (2, 2, 4).

    `free` (2, 2): how far each arm moves; `open_hands` (2, 2): how far it is not in a hold with the other.
    """
    for a in range(2):
        for b in range(2):
            overlap = along[0, a, 0] + along[1, b, 0] + BETWEEN_ARMS - apart
            mine, others = free[0, a] * open_hands[1, b], free[1, b] * open_hands[0, a]
            if overlap <= -OVERLAP_MARGIN or mine + others <= _ZERO:
                continue
            near = _arm_distance(one, 4 * a, other, 4 * b)
            push = _smooth((FAR_ARM - near) / (FAR_ARM - NEAR_ARM)) / max(mine + others, _ONE)
            for k in range(1, 4):
                over = soft(along[0, a, k] + along[1, b, 0] + BETWEEN_ARMS - apart, OVERLAP_MARGIN)
                wish[0, a, k] += (push * mine * over) ** 4
                over = soft(along[1, b, k] + along[0, a, 0] + BETWEEN_ARMS - apart, OVERLAP_MARGIN)
                wish[1, b, k] += (push * others * over) ** 4


@inline_kernel
def _add_trunk_wishes(wish: Float32, along: Float32, one: Float32, other: Float32, apart: Any, free: Float32) -> None:
    """Add by how much each point has to draw back from the other's trunk [m], to the fourth power, to `wish`."""
    for who in range(2):
        arm, body = (one, other) if who == 0 else (other, one)
        for side in range(2):
            if along[who, side, 0] + TO_TRUNK - apart <= -OVERLAP_MARGIN or free[who, side] <= _ZERO:
                continue
            first = 4 * side
            near = segment_distance(arm, first + WRIST, first + PALM_POINT, body, TRUNK_LOW, TRUNK_HIGH)
            near = min(near, segment_distance(arm, first + ELBOW, first + WRIST, body, TRUNK_LOW, TRUNK_HIGH))
            push = free[who, side] * _smooth((FAR_TRUNK - near) / (FAR_TRUNK - NEAR_TRUNK))
            for k in range(1, 4):
                over = soft(along[who, side, k] + TO_TRUNK - apart, OVERLAP_MARGIN)
                wish[who, side, k] += (push * over) ** 4


@inline_kernel
def _way_up(arm: Float32, first: int, k: int) -> Any:
    """Return whether the point `k` of the arm that begins at `first` has room upwards, 1, or rather downwards, -1."""
    return _TWO * _smooth((arm[first + k, 1] - arm[first + SHOULDER, 1]) / RAISED) - _ONE


@inline_kernel
def _find_room(arm: Float32, first: int, along: Float32, nx: Any, nz: Any) -> Any:
    """Return how far a wrist may be drawn back against (nx, nz) [m], so that it stays LEAST_REACH from the shoulder."""
    x, z = arm[first + WRIST, 0] - arm[first + SHOULDER, 0], arm[first + WRIST, 2] - arm[first + SHOULDER, 2]
    y = arm[first + WRIST, 1] - arm[first + SHOULDER, 1]
    on = x * nx + z * nz
    aside = x * x + z * z - on * on + y * y
    return min(along[WRIST] - KEPT, on - math.sqrt(soft(LEAST_REACH * LEAST_REACH - aside, REACH_MARGIN)))


@inline_kernel
def _way_back(wish: Any, room: Any) -> Any:
    """Return how far a point is drawn back [m], no farther than `room` [m]: of both about the shorter, but smooth."""
    room = soft(room, OVERLAP_MARGIN)
    room *= room
    room *= room
    return math.sqrt(math.sqrt(wish * room / max(wish + room, _TINY)))


@inline_kernel
def _draw_arm(
    drawn: Float32, m: int, arm: Float32, first: int, wish: Float32, along: Float32, nx: Any, nz: Any
) -> None:
    """Add to `drawn` by how much elbow and wrist of arm `m` are drawn back against (nx, nz)."""
    over = _way_back(wish[ELBOW], along[ELBOW] - KEPT)
    drawn[m, 0, 0] -= over * nx
    drawn[m, 0, 1] += over * _way_up(arm, first, ELBOW)
    drawn[m, 0, 2] -= over * nz
    over = _way_back(wish[WRIST] + wish[PALM_POINT], _find_room(arm, first, along, nx, nz))
    drawn[m, 1, 0] -= over * nx
    drawn[m, 1, 1] += over * over / (over + FOLDED) * _way_up(arm, first, WRIST)
    drawn[m, 1, 2] -= over * nz


@kernel("void(f4[:,::1], f4[:,::1], i8, i8, f4[:,::1], f4[:,::1], f4[:,:,::1], f4[:,:,::1], f4[:,:,::1])")
def _draw_back(
    one: Float32, other: Float32, i: int, j: int, free: Float32, open_hands: Float32, along: Float32, wish: Float32,
    drawn: Float32,
) -> None:  # fmt: skip
    """Add to `drawn` (2 A, 2, 3) what the dancers `i` and `j`, at the points `one` and `other`, draw back from each
    other; `free` and `open_hands` as in `_add_arm_wishes`, `along` and `wish` (2, 2, 4) are scratch."""
    nx, nz = other[TRUNK_MIDDLE, 0] - one[TRUNK_MIDDLE, 0], other[TRUNK_MIDDLE, 2] - one[TRUNK_MIDDLE, 2]
    apart = math.sqrt(nx * nx + nz * nz)
    if apart < SAME_PLACE:
        return
    nx, nz = nx / apart, nz / apart
    _find_extents(along, one, other, nx, nz)
    longest = max(along[0, 0, 0], along[0, 1, 0])
    longest_other = max(along[1, 0, 0], along[1, 1, 0])
    if longest + longest_other + BETWEEN_ARMS <= apart - OVERLAP_MARGIN and (
        max(longest, longest_other) + TO_TRUNK <= apart - OVERLAP_MARGIN
    ):
        return
    for who in range(2):
        for side in range(2):
            for k in range(4):
                wish[who, side, k] = _ZERO
    _add_arm_wishes(wish, along, one, other, apart, free, open_hands)
    _add_trunk_wishes(wish, along, one, other, apart, free)
    for who in range(2):
        arm, n, sign = (one, i, _ONE) if who == 0 else (other, j, -_ONE)
        for side in range(2):
            if wish[who, side, ELBOW] + wish[who, side, WRIST] + wish[who, side, PALM_POINT] > _ZERO:
                _draw_arm(drawn, 2 * n + side, arm, 4 * side, wish[who, side], along[who, side], sign * nx, sign * nz)


@inline_kernel
def _cell(x: Any, corner: Any, size: Any, cells: int) -> Any:
    """Return the column (or row) of the grid that contains `x` [m]; beyond the last one it is the last one."""
    return np.int64(min(max(_ZERO, (x - corner) / size), np.float32(cells - 1)))


@inline_kernel
def _fit_grid(box: Float32, visible: Bool) -> Any:
    """Return the corner of the grid, x and z [m], the size of its cells [m], its columns and rows, and the number of
    visible dancers."""
    present = 0
    left, back, right, front, size = _FAR, _FAR, -_FAR, -_FAR, LEAST_CELL
    for i in range(box.shape[1]):
        if visible[i]:
            left, right = min(left, box[LEFT, i]), max(right, box[LEFT, i])
            back, front = min(back, box[BACK, i]), max(front, box[BACK, i])
            size = max(size, max(box[RIGHT, i] - box[LEFT, i], box[FRONT, i] - box[BACK, i]))
            present += 1
    most = np.float32(2.0 * math.sqrt(float(box.shape[1])) + 2.0)
    columns = np.int64(min(max(_ONE, (right - left) / size + _ONE), most))
    rows = np.int64(min(max(_ONE, (front - back) / size + _ONE), most))
    return left, back, size, columns, rows, present


@inline_kernel
def _compare_boxes(order: Int32, edges: Float32, cell: Int32, start: Int32, columns: int, rows: int) -> Int32:
    """Return the pairs among the sorted dancers, (P, 2): those behind in the same row of cells, and the next row."""
    pairs, found = np.empty((2 * len(cell), 2), np.int32), 0
    for m in range(len(order)):
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
                        for old in range(found):
                            more[old, 0], more[old, 1] = pairs[old, 0], pairs[old, 1]
                        pairs = more
                    pairs[found, 0], pairs[found, 1] = order[m], order[n]
                    found += 1
    return pairs[:found]


@kernel("i4[:,::1](f4[:,::1], b1[::1])")
def find_pairs(box: Float32, visible: Bool) -> Int32:
    """Return all pairs of `visible` dancers (A,) whose boxes overlap, (P, 2).

    `box` (4, A): LEFT, RIGHT, BACK and FRONT edge of what each dancer fills on the floor [m]. A counting sort into a
    grid as coarse as the largest box: whoever meets is in the same cell or in one beside it.
    """
    count = box.shape[1]
    left, back, size, columns, rows, present = _fit_grid(box, visible)
    start, cell = np.zeros(columns * rows + 2, np.int32), np.empty(count, np.int32)
    for i in range(count):
        if visible[i]:
            row = _cell(box[BACK, i], back, size, rows)
            cell[i] = row * columns + _cell(box[LEFT, i], left, size, columns)
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
    return _compare_boxes(order, edges, cell, start, columns, rows)


@inline_kernel
def _find_freedom(
    free: Float32,
    open_hands: Float32,
    i: int,
    j: int,
    amount: Float32,
    held: Float32,
    partner: Int32,
    together: Float32,
) -> None:
    """Compute for two dancers how far each arm moves, `free` (2, 2), and how far it is not in a hold with the other,
    `open_hands` (2, 2)."""
    couple, apart = False, _ONE
    if len(partner):
        couple = partner[i] == j or partner[j] == i
        apart -= together[i] if partner[i] == j else _ZERO
        apart = min(apart, _ONE - together[j]) if partner[j] == i else apart
    for who in range(2):
        n = i if who == 0 else j
        for side in range(2):
            free[who, side] = apart * amount[2 * n + side]
            open_hands[who, side] = _ONE - held[n, side] if couple else _ONE


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
    free, open_hands = np.empty((2, 2), np.float32), np.empty((2, 2), np.float32)
    along, wish = np.empty((2, 2, 4), np.float32), np.empty((2, 2, 4), np.float32)
    for m in range(len(drawn)):
        for c in range(6):
            drawn[m, c // 3, c % 3] = _ZERO
    last = -1
    for n in range(len(pairs)):
        i, j = pairs[n, 0], pairs[n, 1]
        _find_freedom(free, open_hands, i, j, amount, held, partner, together)
        if i != last:
            _read_points(one, position, rotation, i, trunk, arms)
            last = i
        _read_points(other, position, rotation, j, trunk, arms)
        _draw_back(one, other, i, j, free, open_hands, along, wish, drawn)
