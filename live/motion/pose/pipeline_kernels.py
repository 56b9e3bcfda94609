"""The pose pipeline as one kernel over all dancers in blocks, and the timing drift of dancers (T056)."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.base.scalar_kernels import angle_wrap, ease
from live.motion.pose.foot_lock_kernels import TOES, lock_legs
from live.motion.pose.inertialization_kernels import MAX_FADE_TIME, add_differences
from live.motion.pose.sample_kernels import (
    BLOCK,
    forward_kinematics_rows,
    gather_late_arms,
    gather_samples,
    normalize_rows,
    place_root,
    slerp_rows,
    write_block,
)

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

HEAD_LIMIT = math.radians(60.0)
"""Maximum turn of the head from the chest (T124)."""
PRESENT, PRESENT_TAKE, NEXT, NEXT_TAKE = range(4)
"""Rows of `sample` and `placement`: this measure's clip, the other take mixed into it, and both for the next
measure."""
LOWER, UPPER, INTO_NEXT, NEXT_LOWER, NEXT_UPPER = range(5)
"""Rows of `share`: weights of the other take in the lower and the upper body, weight of the next clip, its takes."""
UPPER_FIRST, UPPER_LAST, CHEST, HEAD = range(4)
"""Entries of `body`: joints UPPER_FIRST..UPPER_LAST-1 are the upper body; -1 if there is no such joint."""
_MAX_FADE_TIME: Any = np.float32(MAX_FADE_TIME)
_ZERO: Any = np.float32(0.0)
_HALF: Any = np.float32(0.5)
_ONE: Any = np.float32(1.0)
_TWO: Any = np.float32(2.0)


@kernel("f8(f8)")
def head_turn(chest: float) -> float:
    """Return the head's turn relative to the chest [rad] for a chest heading `chest`, the audience at 0.

    The head faces the audience while that takes at most 60 degrees. Through the rest of a turn it swings evenly from
    one limit to the other: the linear gap of T124 as a function of the body instead of time, so it needs no look-ahead
    and a spin is spotted. The corners are rounded over 20 degrees, as the Gaussian of T124 rounds them in time.
    """
    turned = abs(angle_wrap(chest))
    far = (math.pi - turned) * HEAD_LIMIT / (math.pi - HEAD_LIMIT)
    gap, soft = far - turned, math.radians(20.0)
    blend = min(max(0.5 + 0.5 * gap / soft, 0.0), 1.0)  # smooth minimum of the two lines
    turn = far + (turned - far) * blend - soft * blend * (1.0 - blend)
    return -math.copysign(max(turn, 0.0), angle_wrap(chest))


@kernel("void(f4[:,:,::1], f4[::1], i8, i8, i8, i8)")
def face_audience(world: Float32, share: Float32, chest: int, head: int, start: int, stop: int) -> None:
    """Turn heads about the vertical towards the audience by the share `share` (A,) (T123, T125: head joint only)."""
    for i in range(min(BLOCK, stop - start)):
        if share[start + i] <= 0.0:
            continue
        w, x, y, z = world[chest, 0, i], world[chest, 1, i], world[chest, 2, i], world[chest, 3, i]
        body = math.atan2(_TWO * (x * z + w * y), _ONE - _TWO * (x * x + y * y))
        w, x, y, z = world[head, 0, i], world[head, 1, i], world[head, 2, i], world[head, 3, i]
        forward_x, forward_z = _TWO * (x * z + w * y), _ONE - _TWO * (x * x + y * y)
        if forward_x * forward_x + forward_z * forward_z < 0.04:  # the head looks at the floor or the sky
            continue
        angle = angle_wrap(body + head_turn(body) - math.atan2(forward_x, forward_z))
        turn = 0.5 * share[start + i] * angle
        c, s = np.float32(math.cos(turn)), np.float32(math.sin(turn))
        world[head, 0, i] = c * w - s * y
        world[head, 1, i] = c * x + s * z
        world[head, 2, i] = c * y + s * w
        world[head, 3, i] = c * z - s * x


@kernel("b1(f4[::1], f4, i8, i8)")
def _any_but(values: Float32, value: float, start: int, stop: int) -> bool:
    """Whether any value of the block differs from `value`."""
    different = False
    for n in range(start, stop):
        different |= values[n] != value
    return different


@kernel("b1(f4[::1], f4, i8, i8)")
def _any_below(values: Float32, value: float, start: int, stop: int) -> bool:
    """Whether any value of the block is below `value`."""
    found = False
    for n in range(start, stop):
        found |= values[n] < value
    return found


@inline_kernel
def _fill_row(row: Float32, values: Float32, start: int, stop: int) -> None:
    for i in range(BLOCK):
        row[i] = values[min(start + i, stop - 1)]


@kernel("void(f4[:,:,::1], f4[:,::1], f4[:,:,::1], f4[:,::1], f4[::1], f4[::1], i4[::1], i8, i8)")
def _mix_take(
    local: Float32, root: Float32, other: Float32, other_root: Float32, lower: Float32, upper: Float32, body: Int32,
    start: int, stop: int,
) -> None:  # fmt: skip
    """Mix another take of the same step into lower and upper body by separate shares (A,) (T044, T045)."""
    row = np.empty(BLOCK, np.float32)
    first, last = body[UPPER_FIRST], body[UPPER_LAST]
    for part in range(3):  # the upper body, the joints before it, those behind it
        if part < 2:
            _fill_row(row, upper if part == 0 else lower, start, stop)
        begin, end = (first, last) if part == 0 else ((0, first) if part == 1 else (last, local.shape[0]))
        slerp_rows(local, other, row, begin, end)
    for c in range(3):
        for i in range(BLOCK):
            root[c, i] += row[i] * (other_root[c, i] - root[c, i])


@kernel("void(f4[:,:,::1], f4[:,:,::1], f4[:,:,::1], i4[:,::1], f4[::1], f4[::1], f4[::1], i4[::1], i8, i8)")
def _amplify(
    local: Float32, other: Float32, mean_rotation: Float32, mean: Int32, into_next: Float32,
    amplitude: Float32, row: Float32, body: Int32, start: int, stop: int,
) -> None:  # fmt: skip
    """Scale the upper body about its mean pose: q' = q_mean (q_mean^-1 q)^r (T058), a SLERP by r from it.

    Within a transition the mean pose is blended, too (T060).
    """
    first, last = body[UPPER_FIRST], body[UPPER_LAST]
    for i in range(BLOCK):
        n = min(start + i, stop - 1)
        a, b, t = mean_rotation[mean[0, n]], mean_rotation[mean[1, n]], into_next[n]
        row[i] = _ONE - amplitude[n]
        for j in range(first, last):
            for c in range(4):
                other[j, c, i] = a[j, c] + t * (b[j, c] - a[j, c])
    normalize_rows(other, first, last)
    slerp_rows(local, other, row, first, last)


@kernel("void(f4[:,:,::1], f4[:,:,::1], i8, i8, i8)")
def _bend_joints(local: Float32, bend: Float32, first: int, start: int, stop: int) -> None:
    """Bend joints from `first` on by `bend` (A, U, 3) [rad], rotation vectors about their parents' axes; (0, 0, 3): not
    at all."""
    half = np.empty((3, BLOCK), np.float32)
    for j in range(bend.shape[1]):
        bent = False
        for i in range(BLOCK):
            n = min(start + i, stop - 1)
            for c in range(3):
                half[c, i] = _HALF * bend[n, j, c]
                bent |= half[c, i] != _ZERO
        for i in range(BLOCK if bent else 0):
            x, y, z = half[0, i], half[1, i], half[2, i]
            w = _ONE / math.sqrt(_ONE + x * x + y * y + z * z)
            x, y, z = w * x, w * y, w * z
            qw, qx, qy, qz = (
                local[first + j, 0, i], local[first + j, 1, i], local[first + j, 2, i], local[first + j, 3, i],
            )  # fmt: skip
            local[first + j, 0, i] = w * qw - x * qx - y * qy - z * qz
            local[first + j, 1, i] = w * qx + x * qw + y * qz - z * qy
            local[first + j, 2, i] = w * qy - x * qz + y * qw + z * qx
            local[first + j, 3, i] = w * qz + x * qy - y * qx + z * qw


@kernel(
    "void(f4[:,:,::1], f4[:,:,::1], f4[:,::1], f4[:,:,::1], f4[:,:,::1], f8[:,::1], f8[:,:,::1], f4[:,::1], i4[:,::1],"
    " f4[::1], f4[:,:,::1], f4[:,::1], f4[::1], f4[:,:,::1], f4[:,:,::1], f4[::1], i4[::1], f4[:,::1], i4[::1],"
    " i4[::1], i4[::1], f4[::1], i8, i8)"
)
def pose_dancers(
    position: Float32, rotation: Float32,
    clip_root: Float32, clip_rotation: Float32, mean_rotation: Float32,
    sample: Float64, placement: Float64, share: Float32, mean: Int32, amplitude: Float32, bend: Float32, late: Float32,
    head: Float32, feet: Float32, difference: Float32, age: Float32, difference_rows: Int32,
    offsets: Float32, parents: Int32, body: Int32, legs: Int32, soles: Float32,
    begin: int, end: int,
) -> None:  # fmt: skip
    """Compute poses of the dancers begin..end-1: clips sampled, mixed, blended, amplified, placed; heads and feet
    adjusted.

    Out: `position` (A, J, 3) world [m], `rotation` (A, J, 4) world. In: all clips as `clip_root` (S, 3) and
    `clip_rotation` (S, J, 4); `mean_rotation` (N, J, 4) each node's mean pose; `sample` (4, A) fractional samples and
    `placement` (4, A, 4) x, z [m], yaw of path and body [rad] of the clips PRESENT .. NEXT_TAKE; `share` (5, A) LOWER
    .. NEXT_UPPER; `mean` (2, A) nodes of the mean poses; `amplitude` (A,) about 1; `bend` (A, U, 3) [rad] of the upper
    body by the mood, or (0, 0, 3); `late` (4, A) samples of each clip by which hands are late, or (0, 0); `head` (A,)
    share of the head's turn to the audience; `feet` (A, 2, 12) as in `foot_lock_kernels` (TOES below 0: legs
    unchanged); `difference`, `age` (A,) [s] and `difference_rows` (J,) as in `inertialization_kernels`. `soles`:
    heights [m] of ankle and toe joint of a standing foot.
    """
    joints = parents.shape[0]
    # allocated here with rows of constant length, so that the compiler can rule out aliasing
    present, coming = np.empty((joints, 4, BLOCK), np.float32), np.empty((joints, 4, BLOCK), np.float32)
    take, roots = np.empty((joints, 4, BLOCK), np.float32), np.empty((4, 3, BLOCK), np.float32)
    world, row = np.empty((joints, 7, BLOCK), np.float32), np.empty(BLOCK, np.float32)
    lanes, asked = np.empty((BLOCK, 4 * joints), np.float32), np.empty(4, np.bool_)
    clips = clip_rotation.reshape((clip_rotation.shape[0], 4 * joints))
    for start in range(begin, end, BLOCK):
        stop = min(start + BLOCK, end)
        blends = _any_but(share[INTO_NEXT], _ZERO, start, stop)
        asked[PRESENT], asked[NEXT] = True, blends
        asked[PRESENT_TAKE] = _any_but(share[LOWER], _ZERO, start, stop) or _any_but(share[UPPER], _ZERO, start, stop)
        mixes = _any_but(share[NEXT_LOWER], _ZERO, start, stop) or _any_but(share[NEXT_UPPER], _ZERO, start, stop)
        asked[NEXT_TAKE] = blends and mixes
        for k in range(4):  # a take is fetched and mixed in right after its clip
            if not asked[k]:
                continue
            local = present if k == PRESENT else (coming if k == NEXT else take)
            gather_samples(local, lanes, clips, sample[k], start, stop)
            gather_late_arms(local, clips, sample[k], late, k, body[HEAD] + 1, body[UPPER_LAST], start, stop)
            place_root(local, roots[k], clip_root, sample[k], placement[k], start, stop)
            if k in (PRESENT_TAKE, NEXT_TAKE):
                lower, own = (LOWER, present) if k == PRESENT_TAKE else (NEXT_LOWER, coming)
                _mix_take(own, roots[k - 1], take, roots[k], share[lower], share[lower + 1], body, start, stop)
        root = roots[PRESENT]
        if blends:
            _fill_row(row, share[INTO_NEXT], start, stop)
            slerp_rows(present, coming, row, 0, joints)
            for c in range(3):
                for i in range(BLOCK):
                    root[c, i] += row[i] * (roots[NEXT, c, i] - root[c, i])
        if _any_but(amplitude, _ONE, start, stop):
            _amplify(present, take, mean_rotation, mean, share[INTO_NEXT], amplitude, row, body, start, stop)
        if _any_below(age, _MAX_FADE_TIME, start, stop):
            add_differences(present, root, difference, age, difference_rows, start, stop)
        _bend_joints(present, bend, body[UPPER_FIRST], start, stop)
        forward_kinematics_rows(world, present, root, offsets, parents)
        if body[HEAD] >= 0 and _any_but(head, _ZERO, start, stop):
            face_audience(world, head, body[CHEST], body[HEAD], start, stop)
        if legs.shape[0] == 8 and feet[start, 0, TOES] >= 0.0:
            lock_legs(world, feet, legs, offsets, soles[0], soles[1], start, stop)
        write_block(position, rotation, world, start, stop)


Int64 = npt.NDArray[np.int64]


@kernel("f8(i8, f8[::1], f8[::1], f8[::1], f8[:,:,::1], f8[::1])")
def drift_lead(n: int, value: Float64, integrals: Float64, phase: Float64, knots: Float64, max_drift: Float64) -> float:
    """Return the lead of dancer `n` [share of a measure]: A(x) sin φ(x), see `Drift.at`."""
    if max_drift[n] == 0.0:
        return 0.0
    amplitude = turned = 0.0
    for k in range(4):
        amplitude += value[k] * knots[0, k, n]
        turned += integrals[k] * knots[1, k, n]
    return float(max_drift[n] * amplitude * math.sin(phase[n] + 2.0 * math.pi * turned))


@kernel("void(f8[::1], i8[::1], f8, f8[::1], f8[:,:,::1], f8[::1], i4[::1], i4[::1])")
def drift_leads(
    out: Float64,
    rows: Int64,
    fraction: float,
    phase: Float64,
    knots: Float64,
    max_drift: Float64,
    previous_model: Int32,
    model: Int32,
) -> None:
    """Compute the lead of the dancers `rows` (n,) at `fraction` of the measure [share of a measure], `out` (n,).

    `phase` (A,) [rad] at the measure's beginning, `knots` (2, 4, A) of amplitude and frequency, `max_drift` (A,)
    maximum drift. Through the measure each dancer blends from the timing of `previous_model` (A,) to that of `model`
    (A,).
    """
    t = fraction
    value, passed = np.empty(4), np.empty(4)
    value[0], value[1] = (1 - t) ** 3 / 6.0, (3 * t**3 - 6 * t**2 + 4) / 6.0
    value[2], value[3] = (-3 * t**3 + 3 * t**2 + 3 * t + 1) / 6.0, t**3 / 6.0
    passed[0], passed[1] = (1 - (1 - t) ** 4) / 24.0, (3 * t**4 - 8 * t**3 + 16 * t) / 24.0
    passed[2], passed[3] = (-3 * t**4 + 4 * t**3 + 6 * t**2 + 4 * t) / 24.0, t**4 / 24.0
    share = ease(fraction)
    for i in range(rows.shape[0]):
        before, after = previous_model[rows[i]], model[rows[i]]
        ahead = drift_lead(before, value, passed, phase, knots, max_drift)
        if after != before:
            ahead += share * (drift_lead(after, value, passed, phase, knots, max_drift) - ahead)
        out[i] = ahead
