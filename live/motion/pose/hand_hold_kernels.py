"""Hand hold kernels: two-bone IK for arms in blocks of holds, for both dancers or for the follower only (H014).

Rows as in `sample_kernels`. An arm is copied into its own rows: upper arm, forearm and hand as rotation (w, x, y, z)
and position [m], then the chest's forward direction, the palm, its goal, and the arm's reach. There are no branches,
and everything is smooth in the poses, so hands move as smoothly as the clips do.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.pose.sample_kernels import BLOCK

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]
Vector = tuple[float, float, float]
Rotation = tuple[float, float, float, float]

PALM: Any = np.float32(0.09)
"""Distance from the wrist to the middle of the palm [m]."""
LENGTH_BUFFER: Any = np.float32(0.01)
"""An arm is not stretched beyond its length minus this [m], unless the clip itself stretches it farther."""
FADE_RANGE: Any = np.float32(0.12)
"""Shoulders nearer than (1 - FADE) of both arms' reach are within reach; beyond that the hold fades out."""
HANG_SHARE: Any = np.float32(0.6)
"""Height of the meeting point: this share of the remaining reach below the line between the shoulders."""
ELBOW_BIAS: Any = np.float32(0.03)
"""Backward bias of the elbow in the upper arm's axes [m]: it decides for a straight elbow, less for a bent one."""
BEHIND_COSINE, ASIDE_COSINE = np.float32(-0.85), np.float32(-0.5)
"""Cosines between the chest's forward axis and the hand's goal: hands are not held behind the back."""
_ZERO: Any = np.float32(0.0)
_ONE: Any = np.float32(1.0)
_TWO: Any = np.float32(2.0)
_THREE: Any = np.float32(3.0)
_TINY: Any = np.float32(1e-12)
UPPER, LOWER, HAND, FORWARD, PALM_ROW, GOAL, REACH, SHARE, ROWS = 0, 7, 14, 21, 24, 27, 30, 31, 32
"""Rows of an arm: first row of each part, and the number of rows."""


@inline_kernel
def _smooth(t: Any) -> Any:
    """Smoothstep: 0 below 0, 1 above 1, zero slope at both."""
    t = min(max(t, _ZERO), _ONE)
    return t * t * (_THREE - _TWO * t)


@inline_kernel
def shortest_rotation(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> Rotation:
    """Return the shortest rotation from direction a to direction b."""
    scale = _ONE / math.sqrt(max((ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz), _TINY))
    w = _ONE + (ax * bx + ay * by + az * bz) * scale
    x, y, z = (ay * bz - az * by) * scale, (az * bx - ax * bz) * scale, (ax * by - ay * bx) * scale
    unit = _ONE / math.sqrt(max(w * w + x * x + y * y + z * z, _TINY))
    return w * unit, x * unit, y * unit, z * unit


@inline_kernel
def multiply(q: Rotation, r: Rotation) -> Rotation:
    """Quaternion product: r first, then q."""
    return (
        q[0] * r[0] - q[1] * r[1] - q[2] * r[2] - q[3] * r[3],
        q[0] * r[1] + q[1] * r[0] + q[2] * r[3] - q[3] * r[2],
        q[0] * r[2] - q[1] * r[3] + q[2] * r[0] + q[3] * r[1],
        q[0] * r[3] + q[1] * r[2] - q[2] * r[1] + q[3] * r[0],
    )


@inline_kernel
def rotate_vector(q: Rotation, x: float, y: float, z: float) -> Vector:
    """Return the vector rotated by q."""
    tx, ty, tz = _TWO * (q[2] * z - q[3] * y), _TWO * (q[3] * x - q[1] * z), _TWO * (q[1] * y - q[2] * x)
    return (
        x + q[0] * tx + q[2] * tz - q[3] * ty,
        y + q[0] * ty + q[3] * tx - q[1] * tz,
        z + q[0] * tz + q[1] * ty - q[2] * tx,
    )


@kernel("void(f4[:,::1], f4[:,:,::1], f4[:,:,::1], i4[:,::1], i4[:,::1], i8, i4[::1], i8, i8)")
def gather_arm(
    arm: Float32, position: Float32, rotation: Float32, who: Int32, hand: Int32, side: int, joints: Int32,
    start: int, stop: int,
) -> None:  # fmt: skip
    """Copy one side's arms of the block into rows; compute the palm and its maximum distance from the shoulder."""
    for i in range(BLOCK):
        n = min(start + i, stop - 1)
        a, left = who[n, side], hand[n, side] == 0
        for k in range(3):
            j = joints[k] if left else joints[3 + k]
            for c in range(4):
                arm[7 * k + c, i] = rotation[a, j, c]
            for c in range(3):
                arm[7 * k + 4 + c, i] = position[a, j, c]
        w, x, y, z = (
            rotation[a, joints[6], 0],
            rotation[a, joints[6], 1],
            rotation[a, joints[6], 2],
            rotation[a, joints[6], 3],
        )
        arm[FORWARD, i] = _TWO * (x * z + w * y)
        arm[FORWARD + 1, i] = _TWO * (y * z - w * x)
        arm[FORWARD + 2, i] = _ONE - _TWO * (x * x + y * y)
        arm[SHARE, i] = PALM if left else -PALM
    for i in range(BLOCK):
        q = arm[HAND, i], arm[HAND + 1, i], arm[HAND + 2, i], arm[HAND + 3, i]
        dx, dy, dz = rotate_vector(q, arm[SHARE, i], _ZERO, _ZERO)
        px, py, pz = arm[HAND + 4, i] + dx, arm[HAND + 5, i] + dy, arm[HAND + 6, i] + dz
        arm[PALM_ROW, i], arm[PALM_ROW + 1, i], arm[PALM_ROW + 2, i] = px, py, pz
        ux, uy, uz = (
            arm[LOWER + 4, i] - arm[UPPER + 4, i],
            arm[LOWER + 5, i] - arm[UPPER + 5, i],
            arm[LOWER + 6, i] - arm[UPPER + 6, i],
        )
        lx, ly, lz = px - arm[LOWER + 4, i], py - arm[LOWER + 5, i], pz - arm[LOWER + 6, i]
        arm[REACH, i] = math.sqrt(ux * ux + uy * uy + uz * uz) + math.sqrt(lx * lx + ly * ly + lz * lz) - LENGTH_BUFFER


@inline_kernel
def _meeting_point(one: Float32, other: Float32, share: Float32, start: int, stop: int) -> None:
    """Compute the goals of both palms of each hold, rows GOAL.. and SHARE: a common point, or their own positions.

    The point stays in a ball within reach of both arms, centred below the line between the shoulders. Its position in
    the ball follows the palms in the clips.
    """
    for i in range(BLOCK):
        sx, sy, sz = one[UPPER + 4, i], one[UPPER + 5, i], one[UPPER + 6, i]
        dx, dy, dz = other[UPPER + 4, i] - sx, other[UPPER + 5, i] - sy, other[UPPER + 6, i] - sz
        whole = one[REACH, i] + other[REACH, i]
        apart = math.sqrt(max(dx * dx + dy * dy + dz * dz, _TINY))
        q = apart / whole
        within = max(_ONE - q * q, _ZERO)
        shorter = min(one[REACH, i], other[REACH, i])
        low = HANG_SHARE * shorter * math.sqrt(within)
        ball = shorter * (_ONE - math.sqrt(min(q * q + HANG_SHARE * HANG_SHARE * within, _ONE))) + _TINY
        part_way, fall = one[REACH, i] / whole, -dy / (apart * apart)
        # downwards, but normal to the line between the shoulders
        cx = sx + part_way * dx - low * fall * dx
        cy = sy + part_way * dy - low * (_ONE + fall * dy)
        cz = sz + part_way * dz - low * fall * dz
        mx = (one[PALM_ROW, i] + other[PALM_ROW, i]) / _TWO - cx
        my = (one[PALM_ROW + 1, i] + other[PALM_ROW + 1, i]) / _TWO - cy
        mz = (one[PALM_ROW + 2, i] + other[PALM_ROW + 2, i]) / _TWO - cz
        scale = ball / math.sqrt(ball * ball + mx * mx + my * my + mz * mz)
        cx, cy, cz = cx + mx * scale, cy + my * scale, cz + mz * scale
        ax, ay, az = cx - sx, cy - sy, cz - sz
        bx, by, bz = ax - dx, ay - dy, az - dz
        front = (ax * one[FORWARD, i] + ay * one[FORWARD + 1, i] + az * one[FORWARD + 2, i]) / math.sqrt(
            max(ax * ax + ay * ay + az * az, _TINY)
        )
        back = (bx * other[FORWARD, i] + by * other[FORWARD + 1, i] + bz * other[FORWARD + 2, i]) / math.sqrt(
            max(bx * bx + by * by + bz * bz, _TINY)
        )
        w = share[min(start + i, stop - 1)] * _smooth((_ONE - q) / FADE_RANGE)
        w = (
            w
            * _smooth((front - BEHIND_COSINE) / (ASIDE_COSINE - BEHIND_COSINE))
            * _smooth((back - BEHIND_COSINE) / (ASIDE_COSINE - BEHIND_COSINE))
        )
        one[SHARE, i], other[SHARE, i] = w, w
        one[GOAL, i], one[GOAL + 1, i], one[GOAL + 2, i] = cx, cy, cz
        other[GOAL, i], other[GOAL + 1, i], other[GOAL + 2, i] = cx, cy, cz


@kernel("void(f4[:,::1])")
def solve_arm(rows: Float32) -> None:
    """Two-bone IK from the shoulder to the palm's goal, in the rows of a block of arms (ROWS, BLOCK): the arm is swung
    as a whole, then bent in its plane."""
    arm = np.empty((ROWS, BLOCK), np.float32)  # a copy, so that the compiler knows that no two rows are the same
    for k in range(ROWS):
        for i in range(BLOCK):
            arm[k, i] = rows[k, i]
    for i in range(BLOCK):
        sx, sy, sz = arm[UPPER + 4, i], arm[UPPER + 5, i], arm[UPPER + 6, i]
        ux, uy, uz = arm[LOWER + 4, i] - sx, arm[LOWER + 5, i] - sy, arm[LOWER + 6, i] - sz
        ex, ey, ez = arm[PALM_ROW, i] - sx, arm[PALM_ROW + 1, i] - sy, arm[PALM_ROW + 2, i] - sz
        lx, ly, lz = ex - ux, ey - uy, ez - uz
        upper, lower = math.sqrt(ux * ux + uy * uy + uz * uz), math.sqrt(lx * lx + ly * ly + lz * lz)
        w = arm[SHARE, i]
        gx = ex + w * (arm[GOAL, i] - sx - ex)
        gy = ey + w * (arm[GOAL + 1, i] - sy - ey)
        gz = ez + w * (arm[GOAL + 2, i] - sz - ez)
        size = math.sqrt(max(gx * gx + gy * gy + gz * gz, _TINY))
        own = math.sqrt(max(ex * ex + ey * ey + ez * ez, _TINY))
        length = min(max(size, abs(upper - lower)), max(arm[REACH, i], own))
        nx, ny, nz = gx / size, gy / size, gz / size
        along = (upper * upper - lower * lower + length * length) / (_TWO * length)
        aside = math.sqrt(max(upper * upper - along * along, _ZERO))
        # the elbow keeps its direction from the line shoulder to palm in the clip, and is swung with that line
        on = (ux * ex + uy * ey + uz * ez) / (own * own)
        qw, qx, qy, qz = arm[UPPER, i], arm[UPPER + 1, i], arm[UPPER + 2, i], arm[UPPER + 3, i]
        px = ux - on * ex - w * ELBOW_BIAS * _TWO * (qx * qz + qw * qy)
        py = uy - on * ey - w * ELBOW_BIAS * _TWO * (qy * qz - qw * qx)
        pz = uz - on * ez - w * ELBOW_BIAS * (_ONE - _TWO * (qx * qx + qy * qy))
        swing = shortest_rotation(ex, ey, ez, gx, gy, gz)
        px, py, pz = rotate_vector(swing, px, py, pz)
        dot = px * nx + py * ny + pz * nz
        px, py, pz = px - dot * nx, py - dot * ny, pz - dot * nz
        scale = aside / math.sqrt(max(px * px + py * py + pz * pz, _TINY))
        kx, ky, kz = along * nx + scale * px, along * ny + scale * py, along * nz + scale * pz
        ux, uy, uz = rotate_vector(swing, ux, uy, uz)
        lx, ly, lz = rotate_vector(swing, lx, ly, lz)
        raised = multiply(shortest_rotation(ux, uy, uz, kx, ky, kz), swing)
        bent = multiply(shortest_rotation(lx, ly, lz, length * nx - kx, length * ny - ky, length * nz - kz), swing)
        wx, wy, wz = (
            arm[HAND + 4, i] - arm[LOWER + 4, i],
            arm[HAND + 5, i] - arm[LOWER + 5, i],
            arm[HAND + 6, i] - arm[LOWER + 6, i],
        )
        wx, wy, wz = rotate_vector(bent, wx, wy, wz)
        r = multiply(raised, (qw, qx, qy, qz))
        arm[UPPER, i], arm[UPPER + 1, i], arm[UPPER + 2, i], arm[UPPER + 3, i] = r
        r = multiply(bent, (arm[LOWER, i], arm[LOWER + 1, i], arm[LOWER + 2, i], arm[LOWER + 3, i]))
        arm[LOWER, i], arm[LOWER + 1, i], arm[LOWER + 2, i], arm[LOWER + 3, i] = r
        r = multiply(bent, (arm[HAND, i], arm[HAND + 1, i], arm[HAND + 2, i], arm[HAND + 3, i]))
        arm[HAND, i], arm[HAND + 1, i], arm[HAND + 2, i], arm[HAND + 3, i] = r
        arm[LOWER + 4, i], arm[LOWER + 5, i], arm[LOWER + 6, i] = sx + kx, sy + ky, sz + kz
        arm[HAND + 4, i], arm[HAND + 5, i], arm[HAND + 6, i] = sx + kx + wx, sy + ky + wy, sz + kz + wz
    for k in range(FORWARD):
        for i in range(BLOCK):
            rows[k, i] = arm[k, i]


@kernel("void(f4[:,::1], f4[:,:,::1], f4[:,:,::1], i4[:,::1], i4[:,::1], i8, i4[::1], i8, i8)")
def scatter_arm(
    arm: Float32, position: Float32, rotation: Float32, who: Int32, hand: Int32, side: int, joints: Int32,
    start: int, stop: int,
) -> None:  # fmt: skip
    """Write the rows back; arms without a hold are unchanged."""
    for i in range(stop - start):
        if arm[SHARE, i] > _ZERO:
            a, left = who[start + i, side], hand[start + i, side] == 0
            for k in range(3):
                j = joints[k] if left else joints[3 + k]
                for c in range(4):
                    rotation[a, j, c] = arm[7 * k + c, i]
                for c in range(3):
                    position[a, j, c] = arm[7 * k + 4 + c, i]


@kernel("void(f4[:,:,::1], f4[:,:,::1], i4[:,::1], i4[:,::1], f4[::1], i4[::1])")
def join_hands(position: Float32, rotation: Float32, who: Int32, hand: Int32, share: Float32, joints: Int32) -> None:
    """Bring the palms of H holds together in the poses `position` (A, J, 3) [m] and `rotation` (A, J, 4), in place.

    `who` (H, 2): the two dancers of each hold; `hand` (H, 2): the hand of each (0 left, 1 right); `share` (H,): how far
    it is closed, 0 to 1; no hand may be in two holds. `joints` (7,): upper arm, forearm and hand of the left and the
    right arm, chest. Elbows keep their direction from the clips, wrists their rotation to the forearm. Shoulders out of
    reach fade the hold to nothing. Two-bone solution by the law of cosines, as for the legs.
    """
    one, other = np.empty((ROWS, BLOCK), np.float32), np.empty((ROWS, BLOCK), np.float32)
    for start in range(0, len(who), BLOCK):
        stop = min(start + BLOCK, len(who))
        gather_arm(one, position, rotation, who, hand, 0, joints, start, stop)
        gather_arm(other, position, rotation, who, hand, 1, joints, start, stop)
        _meeting_point(one, other, share, start, stop)
        solve_arm(one)
        solve_arm(other)
        scatter_arm(one, position, rotation, who, hand, 0, joints, start, stop)
        scatter_arm(other, position, rotation, who, hand, 1, joints, start, stop)


STRAIGHTENING_RANGE: Any = np.float32(0.03)
"""An arm's extension is compressed when it is nearer to straight than this [m], so that the elbow does not snap; at
full reach the palm misses by 0.37 of it."""
ARM_ASIDE: Any = np.float32(0.4)
"""Arms move between positions past the front: this much to their own side and down from the chest's forward axis."""
_LEAST: Any = np.float32(1e-6)


@inline_kernel
def _unit(x: float, y: float, z: float) -> Vector:
    """Return the normalized vector."""
    scale = _ONE / math.sqrt(max(x * x + y * y + z * z, _TINY))
    return x * scale, y * scale, z * scale


@inline_kernel
def _swing(own: Float32, i: int, turn: Rotation) -> None:
    """Rotate the whole arm of lane `i` about its shoulder."""
    sx, sy, sz = own[UPPER + 4, i], own[UPPER + 5, i], own[UPPER + 6, i]
    for row in (LOWER + 4, HAND + 4, PALM_ROW):
        x, y, z = rotate_vector(turn, own[row, i] - sx, own[row + 1, i] - sy, own[row + 2, i] - sz)
        own[row, i], own[row + 1, i], own[row + 2, i] = sx + x, sy + y, sz + z
    for row in (UPPER, LOWER, HAND):
        q = multiply(turn, (own[row, i], own[row + 1, i], own[row + 2, i], own[row + 3, i]))
        own[row, i], own[row + 1, i], own[row + 2, i], own[row + 3, i] = q


@inline_kernel
def _follower_goal(lead: Float32, own: Float32, share: Float32, start: int, stop: int) -> None:
    """Compute the goals of the followers' palms of the block, rows GOAL.. and SHARE: the leaders' palms, within reach.

    On the way the palm's distance from the shoulder is interpolated and the arm passes the front: it is rotated to the
    front first and on from there. It therefore never has to flip, except behind the back.
    """
    for i in range(BLOCK):
        sx, sy, sz = own[UPPER + 4, i], own[UPPER + 5, i], own[UPPER + 6, i]
        gx, gy, gz = lead[PALM_ROW, i] - sx, lead[PALM_ROW + 1, i] - sy, lead[PALM_ROW + 2, i] - sz
        ex, ey, ez = own[PALM_ROW, i] - sx, own[PALM_ROW + 1, i] - sy, own[PALM_ROW + 2, i] - sz
        far = math.sqrt(max(gx * gx + gy * gy + gz * gz, _TINY))
        over = max(far - (own[REACH, i] - STRAIGHTENING_RANGE), _ZERO)
        far = far - over + STRAIGHTENING_RANGE * (_ONE - math.exp(-over / STRAIGHTENING_RANGE))
        near = math.sqrt(max(ex * ex + ey * ey + ez * ez, _TINY))
        gx, gy, gz = _unit(gx, gy, gz)
        ex, ey, ez = _unit(ex, ey, ez)
        side = ARM_ASIDE if own[SHARE, i] > _ZERO else -ARM_ASIDE  # a left palm is at +x of its wrist
        fx, fz = own[FORWARD, i], own[FORWARD + 2, i]
        fx, fy, fz = _unit(fx + side * fz, own[FORWARD + 1, i] - ARM_ASIDE, fz - side * fx)
        w = share[min(start + i, stop - 1)]
        front = w * (_ONE - w) * (_ONE - (ex * gx + ey * gy + ez * gz))
        dx, dy, dz = _unit(
            (_ONE - w) * ex + w * gx + front * fx,
            (_ONE - w) * ey + w * gy + front * fy,
            (_ONE - w) * ez + w * gz + front * fz,
        )
        _swing(own, i, multiply(shortest_rotation(fx, fy, fz, dx, dy, dz), shortest_rotation(ex, ey, ez, fx, fy, fz)))
        # scaled so that `solve_arm`, which applies the share, ends at the palm's current goal
        on = ((_ONE - w) * near + w * far - near) / max(w, _LEAST)
        own[GOAL, i], own[GOAL + 1, i], own[GOAL + 2, i] = (
            own[PALM_ROW, i] + on * dx,
            own[PALM_ROW + 1, i] + on * dy,
            own[PALM_ROW + 2, i] + on * dz,
        )
        own[SHARE, i] = w


@inline_kernel
def _blend_kept_palms(
    lead: Float32, own: Float32, rotation: Float32, kept: Float32, who: Int32, joints: Int32, start: int, stop: int
) -> None:
    """Blend the leaders' palms of the block by the weight in `kept` to their stored position relative to the
    follower."""
    for n in range(start, stop):
        w, i, a, j = kept[n, 3], n - start, who[n, 1], joints[6]
        if w > _ZERO:
            chest = rotation[a, j, 0], rotation[a, j, 1], rotation[a, j, 2], rotation[a, j, 3]
            x, y, z = rotate_vector(chest, kept[n, 0], kept[n, 1], kept[n, 2])
            lead[PALM_ROW, i] += w * (own[UPPER + 4, i] + x - lead[PALM_ROW, i])
            lead[PALM_ROW + 1, i] += w * (own[UPPER + 5, i] + y - lead[PALM_ROW + 1, i])
            lead[PALM_ROW + 2, i] += w * (own[UPPER + 6, i] + z - lead[PALM_ROW + 2, i])


@kernel("void(f4[:,:,::1], f4[:,:,::1], i4[:,::1], i4[:,::1], f4[::1], f4[:,::1], i4[::1])")
def reach_palms(
    position: Float32, rotation: Float32, who: Int32, hand: Int32, share: Float32, kept: Float32, joints: Int32
) -> None:
    """Bring followers' palms to their leaders' in the poses `position` (A, J, 3) [m], `rotation` (A, J, 4), in place.

    `who` (H, 2): leader and follower of each hold; `hand` (H, 2): left (0) or right (1) hand of each; `share` (H,): how
    far the hold is closed, 0 to 1; `joints` as for `join_hands`. `kept` (H, 4): stored position of the leader's palm
    relative to the follower's shoulder in the chest's axes [m], and its weight against the actual position, 0 to 1: a
    released hand is no longer followed. Only the follower's arm moves. A follower's arm is in one hold; a dancer's
    holds as leader come after those as follower. Beyond its reach an arm is straight, never longer.
    """
    lead, own = np.empty((ROWS, BLOCK), np.float32), np.empty((ROWS, BLOCK), np.float32)
    start = 0
    while start < len(who):
        stop = start + 1
        while stop < min(start + BLOCK, len(who)):
            waits = False  # true if the leader's arm is moved in this block
            for n in range(start, stop):
                waits = waits or who[n, 1] == who[stop, 0]
            if waits:
                break
            stop += 1
        gather_arm(lead, position, rotation, who, hand, 0, joints, start, stop)
        gather_arm(own, position, rotation, who, hand, 1, joints, start, stop)
        _blend_kept_palms(lead, own, rotation, kept, who, joints, start, stop)
        _follower_goal(lead, own, share, start, stop)
        solve_arm(own)
        scatter_arm(own, position, rotation, who, hand, 1, joints, start, stop)
        start = stop


@kernel("void(f4[:,:,::1], f4[:,:,::1], i4[:,::1], i4[:,::1], i4[::1], f4[:,::1])")
def measure_reach(position: Float32, rotation: Float32, who: Int32, hand: Int32, joints: Int32, out: Float32) -> None:
    """Measure what followers would have to reach, as in `reach_palms`, into `out` (H, 6).

    Columns: distance of the leader's palm beyond the follower's reach [m], below 0 within reach; cosine between the
    follower's chest forward axis and the palm; distance to the follower's palm [m]; position relative to the follower's
    shoulder in the chest's axes [m].
    """
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
            out[start + i, 3], out[start + i, 4], out[start + i, 5] = rotate_vector(back, gx, gy, gz)
            out[start + i, 2] = math.sqrt(dx * dx + dy * dy + dz * dz)
