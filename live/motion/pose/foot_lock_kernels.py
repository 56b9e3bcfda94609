"""Foot lock kernels: two-bone inverse kinematics for legs in blocks of dancers, and the per-tick lock state.

Rows as in `sample_kernels`: `world` is (J, 7, BLOCK), rotations (w, x, y, z) then positions [m]. The joints of a leg
are copied into a local array with rows of constant length: only then can the compiler rule out aliasing and vectorize
the loops.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.pose.sample_kernels import BLOCK

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]
Rotation = tuple[float, float, float, float]

LENGTH_BUFFER: Any = np.float32(0.015)
"""A leg is not stretched beyond its length minus this [m], unless the clip itself stretches it farther."""
STRAIGHTENING_RANGE: Any = np.float32(0.06)
"""Over the last of this [m] a leg's extension is compressed, so that the knee does not snap straight."""
PELVIS_DROP: Any = np.float32(0.05)
"""Maximum drop of the hips [m] so that both feet reach."""
MAX_SHIFT: Any = np.float32(0.45)
"""Maximum distance [m] of a locked foot from its position in the clip."""
DROP_RATE: Any = np.float32(18.0)
"""Rate at which the hips sink and rise, critically damped [1/s]: a leg that lets go must not throw the body up."""
KNEE_BIAS: Any = np.float32(0.04)
"""Forward bias of the knee direction [m], which decides for a straight knee and matters less for a bent one."""
SHIFT_X, SHIFT_Z, CONTACT_X, CONTACT_Z, TOES, HELD, LIFT, SPEED_X, SPEED_Z, SPEED_Y, SLIDE, STAND_TIME = range(12)
RAISE, RAISE_SPEED, DROP, DROP_SPEED = range(12, 16)
"""Columns of a foot: shift [m] at the last tick, the position [m] of the contact point in the clip then, weight of the
toes in the contact point (the rest is the ankle), 1 while held and 0 while free, lift [m] that put the foot on the
floor when it was held; and, internal to the lock, speeds of shift and lift [m/s], slide [m] during clip contact, its
duration [s], how high a fast foot is raised and by how much the hips sink for this leg [m], with the speeds [m/s]."""
FOLLOWED_COLUMNS, LOCK_COLUMNS = 7, 16
CLEARANCE, CLEARANCE_SOFTNESS, OFFSET_X, OFFSET_Z, HIP_DROP, FEET_COLUMNS = range(7, 13)
"""The first seven columns give the foot's target. Five more are for drawing: minimum height [m], because one of the
blended clips has the foot in the air, the distance [m] over which that minimum sets in smoothly, how far the footstep
plan has the foot from its place in the clip [m], and by how much the hips sink for its leg [m]."""
UNLOCK_DISTANCE: Any = np.float32(0.4)
LOCK_DISTANCE: Any = np.float32(0.2)
JUMP_DISTANCE: Any = np.float32(0.5)
"""A foot is released when its shift exceeds UNLOCK_DISTANCE [m], held again only below LOCK_DISTANCE [m], and never
held through a jump of its clip by more than JUMP_DISTANCE [m] in a tick."""
RELEASE_HALFLIFE: Any = np.float32(0.07)
"""Half-life with which a free foot returns to its clip [s]."""
RAISE_HEIGHT: Any = np.float32(0.06)
"""Height over the floor [m] to which a foot that is fast and free is raised: dragged lower it seems to slide."""
RAISE_FROM: Any = np.float32(0.2)
RAISE_FULL: Any = np.float32(0.45)
"""Speeds over the floor [m/s] at which that sets in, and from which it is complete."""
RAISE_RATE: Any = np.float32(22.0)
"""Rate at which the foot follows, critically damped [1/s]."""
TOE_LIFT: Any = np.float32(0.01)
"""Toes higher than the heel by this [m] are lifted; a flat foot is held by its ball, which stays when it rolls off."""
ROLL_HEIGHT: Any = np.float32(0.001)
"""Height range [m] over which the contact point changes from heel to toes. It is short because a point in between moves
with both. Shifts are accumulated per tick from one point, so the change itself moves nothing."""
_ONSET: Any = np.float32(0.015)
_STRETCH: Any = np.float32(0.005)
_LN2: Any = np.float32(math.log(2.0))
_ZERO: Any = np.float32(0.0)
_HALF: Any = np.float32(0.5)
_ONE: Any = np.float32(1.0)
_TWO: Any = np.float32(2.0)
_TINY: Any = np.float32(1e-12)
_HIP, _KNEE, _ANKLE, _TOES, _GOAL, _ROWS = 0, 7, 14, 21, 28, 31
LEGS = 2 * BLOCK
"""Legs of a block."""


@kernel("f4(f4[:,::1], i8)")
def _length(offsets: Float32, joint: int) -> float:
    o = offsets[joint]
    return math.sqrt(o[0] * o[0] + o[1] * o[1] + o[2] * o[2])


@inline_kernel
def _rotate_shortest(
    ax: float, ay: float, az: float, bx: float, by: float, bz: float, qw: float, qx: float, qy: float, qz: float
) -> Rotation:
    """Return q rotated the shortest way that takes direction a to direction b."""
    scale = _ONE / math.sqrt(max((ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz), _TINY))
    w = _ONE + (ax * bx + ay * by + az * bz) * scale
    x, y, z = (ay * bz - az * by) * scale, (az * bx - ax * bz) * scale, (ax * by - ay * bx) * scale
    unit = _ONE / math.sqrt(max(w * w + x * x + y * y + z * z, _TINY))
    w, x, y, z = w * unit, x * unit, y * unit, z * unit
    return (
        w * qw - x * qx - y * qy - z * qz,
        w * qx + x * qw + y * qz - z * qy,
        w * qy - x * qz + y * qw + z * qx,
        w * qz + x * qy - y * qx + z * qw,
    )


@inline_kernel
def _ankle_goal(
    leg: Float32, asked: Float32, feet: Float32, sole: float, toes_over_sole: float, start: int, stop: int
) -> None:
    """Compute the ankle target, rows _GOAL.. of `leg` [m].

    A held foot's contact point stays where it was at the last tick; a free one keeps its decaying shift and lift. No
    sole goes below the floor, or below the height CLEAR.
    """
    for i in range(LEGS):
        row = feet[min(start + i % BLOCK, stop - 1), i // BLOCK]
        for c in range(FEET_COLUMNS):
            asked[c, i] = row[c]
    for i in range(LEGS):
        ax, ay, az = leg[_ANKLE + 4, i], leg[_ANKLE + 5, i], leg[_ANKLE + 6, i]
        px = ax + asked[TOES, i] * (leg[_TOES + 4, i] - ax) + asked[OFFSET_X, i]
        pz = az + asked[TOES, i] * (leg[_TOES + 6, i] - az) + asked[OFFSET_Z, i]
        dx = asked[SHIFT_X, i] - asked[HELD, i] * (px - asked[CONTACT_X, i])
        dz = asked[SHIFT_Z, i] - asked[HELD, i] * (pz - asked[CONTACT_Z, i])
        scale = MAX_SHIFT / math.sqrt(max(dx * dx + dz * dz, MAX_SHIFT * MAX_SHIFT))
        low = min(ay - sole, leg[_TOES + 5, i] - toes_over_sole)
        leg[_GOAL, i] = ax + asked[OFFSET_X, i] + dx * scale
        clear = asked[CLEARANCE, i] - low
        clear = _HALF * (clear + math.sqrt(clear * clear + asked[CLEARANCE_SOFTNESS, i] * asked[CLEARANCE_SOFTNESS, i]))
        leg[_GOAL + 1, i] = ay + max(clear, (_ONE - asked[HELD, i]) * asked[LIFT, i])
        leg[_GOAL + 2, i] = az + asked[OFFSET_Z, i] + dz * scale


@kernel("f4(f4, f4, f4, f4, f4)")
def hip_drop(leg: float, flat: float, height: float, own: float, room: float) -> float:
    """Return by how much the hips must sink so that a leg of length `leg` nearly reaches its goal [m].

    The goal is `flat` [m] beside the hip and `height` [m] below it; `own` [m] is the leg's length in the clip. The drop
    starts smoothly and approaches `room` [m]: with a hard limit it would stop abruptly and the knee would snap.
    """
    limit = max(leg - LENGTH_BUFFER - _HALF * STRAIGHTENING_RANGE, own)
    missing = max(height - math.sqrt(max(limit * limit - flat * flat, _ZERO)), _ZERO)
    missing = missing * missing / (missing + _ONSET)
    drop: float = missing * room / (missing + room)
    return drop


@inline_kernel
def _solve_leg(leg: Float32, drop: Float32, upper: float, lower: float) -> None:
    """Two-bone IK from the lowered hip to the goal with the knee kept in its plane; foot and toes keep their
    rotation."""
    whole = upper + lower
    for i in range(LEGS):
        hx, hy, hz = leg[_HIP + 4, i], leg[_HIP + 5, i], leg[_HIP + 6, i]
        ux, uy, uz = leg[_KNEE + 4, i] - hx, leg[_KNEE + 5, i] - hy, leg[_KNEE + 6, i] - hz
        ex, ey, ez = leg[_ANKLE + 4, i] - hx, leg[_ANKLE + 5, i] - hy, leg[_ANKLE + 6, i] - hz
        lx, ly, lz = ex - ux, ey - uy, ez - uz
        hy = hy - drop[i]
        gx, gy, gz = leg[_GOAL, i] - hx, leg[_GOAL + 1, i] - hy, leg[_GOAL + 2, i] - hz
        size = math.sqrt(max(gx * gx + gy * gy + gz * gz, _TINY))
        own = math.sqrt(ex * ex + ey * ey + ez * ez)
        easy = max(own, whole - LENGTH_BUFFER - STRAIGHTENING_RANGE)
        room = max(whole - LENGTH_BUFFER, own + _STRETCH) - easy
        beyond = max(size - easy, _ZERO) / room
        length = min(size, easy) + room * beyond / math.sqrt(_ONE + beyond * beyond)
        nx, ny, nz = gx / size, gy / size, gz / size
        along = (upper * upper - lower * lower + length * length) / (_TWO * length)
        aside = math.sqrt(max(upper * upper - along * along, _ZERO))
        # the knee keeps its direction from the line hip to ankle in the clip; forward in a straight leg
        w, x, y, z = leg[_HIP, i], leg[_HIP + 1, i], leg[_HIP + 2, i], leg[_HIP + 3, i]
        part = (ux * ex + uy * ey + uz * ez) / max(ex * ex + ey * ey + ez * ez, _TINY)
        px = ux - part * ex + KNEE_BIAS * (x * z + w * y)
        py = uy - part * ey + KNEE_BIAS * (y * z - w * x)
        pz = uz - part * ez + KNEE_BIAS * (_HALF - x * x - y * y)
        dot = px * nx + py * ny + pz * nz
        px, py, pz = px - dot * nx, py - dot * ny, pz - dot * nz
        scale = aside / math.sqrt(max(px * px + py * py + pz * pz, _TINY))
        kx, ky, kz = along * nx + scale * px, along * ny + scale * py, along * nz + scale * pz
        fx, fy, fz = length * nx, length * ny, length * nz
        w, x, y, z = _rotate_shortest(ux, uy, uz, kx, ky, kz, w, x, y, z)
        leg[_HIP, i], leg[_HIP + 1, i], leg[_HIP + 2, i], leg[_HIP + 3, i] = w, x, y, z
        w, x, y, z = leg[_KNEE, i], leg[_KNEE + 1, i], leg[_KNEE + 2, i], leg[_KNEE + 3, i]
        w, x, y, z = _rotate_shortest(lx, ly, lz, fx - kx, fy - ky, fz - kz, w, x, y, z)
        leg[_KNEE, i], leg[_KNEE + 1, i], leg[_KNEE + 2, i], leg[_KNEE + 3, i] = w, x, y, z
        leg[_KNEE + 4, i], leg[_KNEE + 5, i], leg[_KNEE + 6, i] = hx + kx, hy + ky, hz + kz
        dx, dy, dz = hx + fx - leg[_ANKLE + 4, i], hy + fy - leg[_ANKLE + 5, i], hz + fz - leg[_ANKLE + 6, i]
        leg[_ANKLE + 4, i], leg[_ANKLE + 5, i], leg[_ANKLE + 6, i] = hx + fx, hy + fy, hz + fz
        leg[_TOES + 4, i] += dx
        leg[_TOES + 5, i] += dy
        leg[_TOES + 6, i] += dz
        leg[_HIP + 5, i] = hy


@kernel("void(f4[:,:,::1], f4[:,:,::1], i4[::1], f4[:,::1], f4, f4, i8, i8)")
def lock_legs(
    world: Float32,
    feet: Float32,
    legs: Int32,
    offsets: Float32,
    sole: float,
    toes_over_sole: float,
    start: int,
    stop: int,
) -> None:
    """Apply the foot lock to a block: feet to their targets, hips slightly lowered if a leg is too short.

    `feet` (A, 2, 12): targets; `legs` (8,): hip, knee, ankle and toes of the left and the right leg; `sole` and
    `toes_over_sole` [m]: heights of ankle and toe joint of a standing foot. Unlock radius, length buffer and two-bone
    legs as in Holden's Motion-Matching; without branches and trigonometry, so that blocks are vectorized. The right
    legs of the block stand in the rows behind the left ones.
    """
    leg = np.empty((_ROWS, LEGS), np.float32)
    asked, drop = np.empty((FEET_COLUMNS, LEGS), np.float32), np.empty(LEGS, np.float32)
    for j in range(8):
        for c in range(7):
            for i in range(BLOCK):
                leg[7 * (j % 4) + c, BLOCK * (j // 4) + i] = world[legs[j], c, i]
    upper, lower = _length(offsets, legs[1]), _length(offsets, legs[2])
    _ankle_goal(leg, asked, feet, sole, toes_over_sole, start, stop)
    for i in range(LEGS):
        n = min(start + i % BLOCK, stop - 1)
        drop[i] = max(max(feet[n, 0, HIP_DROP], feet[n, 1, HIP_DROP]), _ZERO)
    _solve_leg(leg, drop, upper, lower)
    for j in range(world.shape[0]):
        for i in range(BLOCK):
            world[j, 5, i] -= drop[i]
    for j in range(8):
        for c in range(7):
            for i in range(BLOCK):
                world[legs[j], c, i] = leg[7 * (j % 4) + c, BLOCK * (j // 4) + i]


@kernel("void(f4[:,:,::1], f4[:,:,::1], b1[:,::1], b1[:,::1], f4, f4, f4, f4)")
def update_lock(
    lock: Float32,
    leg_position: Float32,
    contact: Bool,
    landing: Bool,
    leg: float,
    sole: float,
    toes_over_sole: float,
    dt: float,
) -> None:
    """Advance the foot lock of A dancers by one tick: `lock` (A, 2, 16) follows the unlocked feet.

    `leg_position` (A, 9, 3) [m]: hips, then hip, knee, ankle and toes of the left and the right leg in the clips;
    `contact` (A, 2): whether the clips have the foot on the floor; `landing` (A, 2): whether they soon will; `leg` [m]:
    length of a leg. During contact the
    contact point is held: the shift compensates its movement exactly. The contact point is the lower one of ankle and
    toes, so the foot may roll from heel to ball. A foot shifted too far is released. Free feet return to their clip,
    critically damped from their current speed: horizontally, and downwards if a blended clip had to be lifted to stand
    on the floor. A free foot that is fast and does not land is raised, and the hips sink for a leg that is too short.
    """
    decay = _TWO * _LN2 / RELEASE_HALFLIFE
    for n in range(lock.shape[0]):
        for side in range(2):
            row = lock[n, side]
            ankle, toes = leg_position[n, 3 + 4 * side], leg_position[n, 4 + 4 * side]
            x = ankle[0] + row[TOES] * (toes[0] - ankle[0])
            z = ankle[2] + row[TOES] * (toes[2] - ankle[2])
            moved_x, moved_z = x - row[CONTACT_X], z - row[CONTACT_Z]
            below = max(-min(ankle[1] - sole, toes[1] - toes_over_sole), _ZERO)
            if row[HELD] > _ZERO:
                row[SPEED_Y], row[LIFT] = (below - row[LIFT]) / dt, below
            else:
                fall = math.exp(-decay * dt)
                bend = row[SPEED_Y] + row[LIFT] * decay
                row[LIFT] = fall * (row[LIFT] + bend * dt)
                row[SPEED_Y] = fall * (row[SPEED_Y] - bend * decay * dt)
            slid_x, slid_z = moved_x - row[SHIFT_X], moved_z - row[SHIFT_Z]
            if row[HELD] > _ZERO and moved_x * moved_x + moved_z * moved_z < JUMP_DISTANCE * JUMP_DISTANCE:
                row[SHIFT_X] -= moved_x
                row[SHIFT_Z] -= moved_z
                row[SPEED_X], row[SPEED_Z] = -moved_x / dt, -moved_z / dt
            else:
                fall = math.exp(-decay * dt)
                bend_x, bend_z = row[SPEED_X] + row[SHIFT_X] * decay, row[SPEED_Z] + row[SHIFT_Z] * decay
                row[SHIFT_X] = fall * (row[SHIFT_X] + bend_x * dt)
                row[SHIFT_Z] = fall * (row[SHIFT_Z] + bend_z * dt)
                row[SPEED_X] = fall * (row[SPEED_X] - bend_x * decay * dt)
                row[SPEED_Z] = fall * (row[SPEED_Z] - bend_z * decay * dt)
            gone_x, gone_z = slid_x + row[SHIFT_X], slid_z + row[SHIFT_Z]
            speed = math.sqrt(gone_x * gone_x + gone_z * gone_z) / max(dt, _TINY)
            part = min(max((speed - RAISE_FROM) / (RAISE_FULL - RAISE_FROM), _ZERO), _ONE)
            lost = part != part  # a pose that is lost is not a number
            if row[HELD] > _ZERO or contact[n, side] or landing[n, side] or lost:
                part = _ZERO
            wanted = RAISE_HEIGHT * part * part * (_ONE + _TWO - _TWO * part)
            fall = math.exp(-RAISE_RATE * dt)
            bend = row[RAISE_SPEED] + (row[RAISE] - wanted) * RAISE_RATE
            row[RAISE] = wanted + fall * (row[RAISE] - wanted + bend * dt)
            row[RAISE_SPEED] = fall * (row[RAISE_SPEED] - bend * RAISE_RATE * dt)
            hip = leg_position[n, 1 + 4 * side]
            away_x, away_y, away_z = ankle[0] - hip[0], ankle[1] - hip[1], ankle[2] - hip[2]
            own = math.sqrt(away_x * away_x + away_y * away_y + away_z * away_z)
            away_x, away_z = away_x + row[SHIFT_X], away_z + row[SHIFT_Z]
            flat = math.sqrt(away_x * away_x + away_z * away_z)
            wanted = hip_drop(leg, flat, -away_y - row[RAISE], own, PELVIS_DROP)
            wanted = wanted if wanted == wanted else _ZERO
            fall = math.exp(-DROP_RATE * dt)
            bend = row[DROP_SPEED] + (row[DROP] - wanted) * DROP_RATE
            row[DROP] = wanted + fall * (row[DROP] - wanted + bend * dt)
            row[DROP_SPEED] = fall * (row[DROP_SPEED] - bend * DROP_RATE * dt)
            followed = (
                row[CONTACT_X] != _ZERO or row[CONTACT_Z] != _ZERO
            )  # false if this foot has not been followed yet
            if contact[n, side] and followed:
                slid_x, slid_z = slid_x + row[SHIFT_X], slid_z + row[SHIFT_Z]
                row[SLIDE] += math.sqrt(slid_x * slid_x + slid_z * slid_z)
                row[STAND_TIME] += dt
            shift = math.sqrt(row[SHIFT_X] * row[SHIFT_X] + row[SHIFT_Z] * row[SHIFT_Z])
            stands = contact[n, side] and shift < (UNLOCK_DISTANCE if row[HELD] > _ZERO else LOCK_DISTANCE)
            row[HELD] = _ONE if stands else _ZERO
            lift = (ankle[1] - sole) - (toes[1] - toes_over_sole)
            row[TOES] = min(max(_HALF + (lift + TOE_LIFT) / ROLL_HEIGHT, _ZERO), _ONE)
            row[CONTACT_X] = ankle[0] + row[TOES] * (toes[0] - ankle[0])
            row[CONTACT_Z] = ankle[2] + row[TOES] * (toes[2] - ankle[2])


Float64 = npt.NDArray[np.float64]


@kernel("void(f4[:,:,::1], f4[:,:,::1], f4)")
def extrapolate_feet(feet: Float32, lock: Float32, age: float) -> None:
    """Write `feet` (A, 2, 12) from the lock state `lock` (A, 2, 16), `age` [s] after its tick; free feet are
    extrapolated."""
    for n in range(lock.shape[0]):
        for side in range(2):
            row, out = lock[n, side], feet[n, side]
            for c in range(FOLLOWED_COLUMNS):
                out[c] = row[c]
            out[HIP_DROP] = row[DROP] + age * row[DROP_SPEED]
            free = age * (np.float32(1.0) - row[HELD])
            out[SHIFT_X] += free * row[SPEED_X]
            out[SHIFT_Z] += free * row[SPEED_Z]
            out[LIFT] += free * row[SPEED_Y]


@kernel("f4(f4[:,:,::1])")
def farthest_shift(lock: Float32) -> float:
    """Return the largest shift [m] of any foot of `lock` (A, 2, 16) along x or z."""
    most: float = np.float32(0.0)  # type: ignore[assignment]
    for n in range(lock.shape[0]):
        for side in range(2):
            most = max(most, max(abs(lock[n, side, SHIFT_X]), abs(lock[n, side, SHIFT_Z])))
    return most


@kernel("void(f4[:,:,::1], f8[::1], f8[::1])")
def pop_slide(lock: Float32, slid: Float64, stood: Float64) -> None:
    """Read and reset the slide of both feet, `slid` (A,) [m], and its duration, `stood` (A,) [s]."""
    for n in range(lock.shape[0]):
        slid[n] = float(lock[n, 0, SLIDE]) + float(lock[n, 1, SLIDE])
        stood[n] = float(lock[n, 0, STAND_TIME]) + float(lock[n, 1, STAND_TIME])
        for side in range(2):
            lock[n, side, SLIDE] = lock[n, side, STAND_TIME] = np.float32(0.0)


@kernel("void(f4[:,:,::1], f8[:,:,::1])")
def held_foot_shifts(lock: Float32, held: Float64) -> None:
    """Compute the shift of each held foot of the lock (A, 2, 16) from its clip, `held` (A, 2, 2) [m]; 0 for free
    feet."""
    for n in range(lock.shape[0]):
        for foot in range(2):
            held[n, foot, 0] = float(lock[n, foot, SHIFT_X]) * lock[n, foot, HELD]
            held[n, foot, 1] = float(lock[n, foot, SHIFT_Z]) * lock[n, foot, HELD]
