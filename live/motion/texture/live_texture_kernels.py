"""Kernels of real-time texturing: match the legs' prefix to a fragment, and blend the fragment into the upper body."""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]
Bool = npt.NDArray[np.bool_]

PER_BEAT: Final = 16
"""Samples a beat in a bank."""
SLOTS: Final = 7
"""Moments at which legs are compared: every eighth of a beat, from half a beat before a beat to a quarter after."""
FEATURES: Final = 12
"""Coordinates of both knees and ankles."""
DERIVATIVE: Final = 2.0
"""Weight of the legs' movement from one moment to the next, against their positions."""
DIMENSIONS: Final = (2 * SLOTS - 1) * FEATURES
"""Size of the feature vector of a beat: knees and ankles at all moments, and their changes."""
LAGS: Final = 9
"""Moments, every eighth of a beat, of the last beat, with both ends: what tells the upper body to come."""
LIMIT: Final = 2.0 / math.sqrt(LAGS * FEATURES)
"""A scaled coordinate of a leg counts as this at most, two widths of the kernel: slopes do not reach beyond what is
known."""
NEVER: Final = -(1 << 40)
"""A moment or beat before all others."""
UPPER_COUNT: Final = 13
"""Joints of the upper body: consecutive joints after the hips, starting at joint 1."""
NECK_INDEX: Final = 3
"""Index of the neck among these; the head is the next one."""


@kernel("void(f4[:,::1], f4[:,:,::1], f4[:,:,::1])")
def measure_legs(out: Float32, position: Float32, rotation: Float32) -> None:
    """Write knees and ankles in the axes of the hips to `out` (A, FEATURES).

    `position` and `rotation` (A, 9, 3 or 4), world: hips, then thigh, shin, foot and toes of the left and right leg.
    """
    for a in range(out.shape[0]):
        w, x, y, z = rotation[a, 0, 0], -rotation[a, 0, 1], -rotation[a, 0, 2], -rotation[a, 0, 3]
        for n in range(4):
            joint = 2 + (n & 1) + 4 * (n >> 1)
            vx = position[a, joint, 0] - position[a, 0, 0]
            vy = position[a, joint, 1] - position[a, 0, 1]
            vz = position[a, joint, 2] - position[a, 0, 2]
            tx = 2.0 * (y * vz - z * vy)
            ty = 2.0 * (z * vx - x * vz)
            tz = 2.0 * (x * vy - y * vx)
            out[a, 3 * n] = vx + w * tx + y * tz - z * ty
            out[a, 3 * n + 1] = vy + w * ty + z * tx - x * tz
            out[a, 3 * n + 2] = vz + w * tz + x * ty - y * tx


@kernel("void(f4[:,:,::1], f4[:,::1], f4[:,::1], f8[::1], f8[::1], i4)")
def record_moments(
    history: Float32, before: Float32, now: Float32, previous_beat: Float64, current_beat: Float64, per_beat: int
) -> None:
    """Record the leg features at every 1 / `per_beat` beat passed since the last tick in `history` (A, slots, n).

    `before` and `now` (A, n) are the features at the last tick and now, at the dancers' beats `previous_beat` and
    `current_beat` (A,). Features are interpolated linearly between them.
    """
    slots = history.shape[1]
    for a in range(history.shape[0]):
        way = current_beat[a] - previous_beat[a]
        first, last = math.floor(previous_beat[a] * per_beat) + 1, math.floor(current_beat[a] * per_beat)
        if not way > 0.0 or last - first >= slots:
            first = last
        for moment in range(first, last + 1):
            part = 1.0
            if way > 0.0:
                part = min(max((moment / per_beat - previous_beat[a]) / way, 0.0), 1.0)
            for n in range(history.shape[2]):
                history[a, int(moment % slots), n] = before[a, n] + part * (now[a, n] - before[a, n])


@kernel("void(f4[::1], f4[:,::1], i8, f4[::1], f4[::1], f4[::1], f4[:,::1], f4[:,::1], f4[:,::1])")
def _predict(
    out: Float32,
    history: Float32,
    moment: int,
    near: Float32,
    middle: Float32,
    scale: Float32,
    centres: Float32,
    weights: Float32,
    slopes: Float32,
) -> None:
    """Predict the upper body, `out` (3 UPPER_COUNT,), from the legs in `history` (moments, FEATURES) up to `moment`."""
    count = centres.shape[1]
    for n in range(out.shape[0]):
        out[n] = 0.0
    for m in range(count):
        near[m] = 0.0
    for d in range(LAGS * FEATURES):
        row = int((moment - d // FEATURES) % history.shape[0])
        value = (history[row, d % FEATURES] - middle[d]) * scale[d]
        within = np.float32(min(max(value, -LIMIT), LIMIT))
        for n in range(out.shape[0]):
            out[n] += within * slopes[d, n]
        for m in range(count):
            away = centres[d, m] - value
            near[m] += away * away
    for m in range(count):
        share = np.float32(math.exp(-0.5 * near[m]))
        for n in range(out.shape[0]):
            out[n] += share * weights[m, n]


@kernel(
    "void(f4[:,:,::1], i8[::1], b1[::1], f8[::1], f4[:,:,::1], f4[::1], f4[::1], f4[::1], f4[:,::1], f4[:,::1],"
    " f4[:,::1])"
)
def follow_legs(
    told: Float32,
    told_moment: Int64,
    wanted: Bool,
    beat: Float64,
    history: Float32,
    near: Float32,
    middle: Float32,
    scale: Float32,
    centres: Float32,
    weights: Float32,
    slopes: Float32,
) -> None:
    """Predict upper bodies from the last beat of legs, for each dancer `wanted` (A,) that reached an eighth of a beat.

    `told` (A, 3, 3 UPPER_COUNT) holds the last three predictions, the newest last; `told_moment` (A,) is the newest
    one's moment, NEVER before the first. `history` (A, moments, FEATURES) is as `record_moments` leaves it at `beat`
    (A,). The rest is a `LivePrediction`, with M centres; `near` (M,) is scratch.
    """
    for a in range(told.shape[0]):
        moment = math.floor(8.0 * beat[a])
        if not wanted[a]:
            told_moment[a] = NEVER
        elif moment != told_moment[a]:
            for n in range(told.shape[2]):
                told[a, 0, n], told[a, 1, n] = told[a, 1, n], told[a, 2, n]
            _predict(told[a, 2], history[a], moment, near, middle, scale, centres, weights, slopes)
            if told_moment[a] == NEVER:
                for n in range(told.shape[2]):
                    told[a, 0, n] = told[a, 1, n] = told[a, 2, n]
            told_moment[a] = moment


@kernel("i8(i8,i8,i8)")
def hash_24bit(seed: int, dancer: int, fragment: int) -> int:
    """Return a 24-bit hash of the three values, used as a random number."""
    value = (seed * 0x9E3779B1 + dancer * 0x85EBCA6B + fragment * 0xC2B2AE35) & 0xFFFFFFFF
    value = ((value ^ (value >> 15)) * 0x2C1B3C6D) & 0xFFFFFFFF
    value = ((value ^ (value >> 12)) * 0x297A2D39) & 0xFFFFFFFF
    return (value ^ (value >> 15)) >> 8


@kernel("void(f4[::1], f4[:,::1], i8)")
def write_prefix(own: Float32, history: Float32, line: int) -> None:
    """Write the features of the legs around the beat `line` to `own` (D,), from `history` (moments, FEATURES).

    They are knees and ankles at SLOTS moments, then their changes, in the layout of the stored fragments.
    """
    moments = history.shape[0]
    for slot in range(SLOTS):
        row = int((8 * line + slot - SLOTS // 2 - 1) % moments)
        for n in range(FEATURES):
            own[slot * FEATURES + n] = history[row, n]
    for n in range((SLOTS - 1) * FEATURES):
        own[SLOTS * FEATURES + n] = np.float32(DERIVATIVE) * (own[n + FEATURES] - own[n])


@kernel("i8(f4[::1], f4[:,::1], f4[::1], i8, f8, f8, i8, i8)")
def nearest_fragment(
    distances: Float32,
    legs: Float32,
    own: Float32,
    continuation: int,
    join: float,
    preference: float,
    seed: int,
    dancer: int,
) -> int:
    """Return the fragment, of F, whose legs are most like `own` (D,); `legs` is (D, F), `distances` (F,) is scratch.

    Every fragment except `continuation` (-1: none) costs `join` more. Distances are multiplied by a random
    factor from 1 to 1 + `preference` for each dancer and fragment, so dancers prefer different fragments.
    """
    count = distances.shape[0]
    for f in range(count):
        distances[f] = 0.0
    for d in range(legs.shape[0]):
        value = own[d]
        for f in range(count):
            away = legs[d, f] - value
            distances[f] += away * away
    best, least = 0, np.inf
    for f in range(count):
        cost = float(distances[f]) * (1.0 + preference * hash_24bit(seed, dancer, f) / 16777216.0)
        if f != continuation:
            cost += join
        if cost < least:
            best, least = f, cost
    return best


@kernel("void(f4[::1], f4[:,:,::1], i8, f8, i8, i8)")
def _read(out: Float32, upper: Float32, joint: int, sample: float, first: int, last: int) -> None:
    """Read the rotation of a joint at a fractional `sample`, by a cubic through four samples, not normalized."""
    at = min(max(sample, float(first)), float(last))
    low = min(int(at), max(last - 1, first))
    t = np.float32(at - low)
    half = np.float32(0.5)
    a = half * (-t + np.float32(2.0) * t * t - t * t * t)
    b = half * (np.float32(2.0) - np.float32(5.0) * t * t + np.float32(3.0) * t * t * t)
    c = half * (t + np.float32(4.0) * t * t - np.float32(3.0) * t * t * t)
    d = half * (-t * t + t * t * t)
    rows = (max(low - 1, first), low, min(low + 1, last), min(low + 2, last))
    weights = (a, b, c, d)
    for k in range(4):
        out[k] = 0.0
    for n in range(4):
        for k in range(4):
            out[k] += weights[n] * upper[rows[n], joint, k]


@kernel("void(f4[::1])")
def _unit(q: Float32) -> None:
    """Normalize `q` in place; a zero quaternion becomes the identity."""
    size = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    if size < 1e-6:
        q[0], size = 1.0, 1.0
    scale = np.float32(1.0 / size)
    for k in range(4):
        q[k] *= scale


@kernel("i8(f4[:,:,::1], f8, i4[::1], f8, i4[::1], i8, f4[:,::1], b1)")
def signs_of(
    upper: Float32,
    sample: float,
    limits: Int32,
    other_sample: float,
    other_limits: Int32,
    other_signs: int,
    mean_rotations: Float32,
    full_texture: bool,
) -> int:
    """Return a bit for each joint whose quaternion at `sample` must be read with the opposite sign.

    If texture fully covers the pose (`full_texture`), the sign gives the shorter way from `other_sample`, read with the
    signs `other_signs`. Otherwise it gives the shorter way from `mean_rotations`, which steps are close to.
    """
    a, b = np.empty(4, np.float32), np.empty(4, np.float32)
    bits = 0
    for n in range(UPPER_COUNT):
        _read(a, upper, n, sample, limits[0], limits[1])
        sign = np.float32(1.0)
        if full_texture:
            _read(b, upper, n, other_sample, other_limits[0], other_limits[1])
            if (other_signs >> n) & 1:
                sign = np.float32(-1.0)
        else:
            for k in range(4):
                b[k] = mean_rotations[n, k]
        if sign * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]) < 0.0:
            bits |= 1 << n
    return bits


@kernel("void(f4[::1], f4[::1], f4[::1], f8)")
def _slerp_signed(out: Float32, a: Float32, b: Float32, share: float) -> None:
    """Interpolate from unit quaternion `a` to `b` at constant speed, without flipping signs to the shorter way.

    So nothing jumps where the two are half a turn apart.
    """
    dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
    left, right = 1.0 - share, share
    if dot < 0.999:
        angle = math.acos(max(float(dot), -0.999))
        scale = 1.0 / math.sin(angle)
        left, right = math.sin(left * angle) * scale, math.sin(right * angle) * scale
    for k in range(4):
        out[k] = np.float32(left) * a[k] + np.float32(right) * b[k]


@kernel("void(f4[::1], f4[:,::1], i8, f8)")
def _turn_as_told(q: Float32, told: Float32, joint: int, part: float) -> None:
    """Turn `q` in its parent's axes by what is `told` (3, 3 UPPER_COUNT) of a joint, `part` of an eighth after it was.

    The vector runs along the quadratic B-spline of the three predictions, so it has no kinks.
    """
    t = min(max(part, 0.0), 1.0)
    a, b, c = 0.5 * (1.0 - t) * (1.0 - t), 0.5 + t * (1.0 - t), 0.5 * t * t
    x = a * told[0, 3 * joint] + b * told[1, 3 * joint] + c * told[2, 3 * joint]
    y = a * told[0, 3 * joint + 1] + b * told[1, 3 * joint + 1] + c * told[2, 3 * joint + 1]
    z = a * told[0, 3 * joint + 2] + b * told[1, 3 * joint + 2] + c * told[2, 3 * joint + 2]
    angle = math.sqrt(x * x + y * y + z * z)
    if angle < 1e-9:
        return
    size = math.sin(0.5 * angle) / angle
    w, x, y, z = math.cos(0.5 * angle), x * size, y * size, z * size
    qw, qx, qy, qz = q[0], q[1], q[2], q[3]
    q[0] = w * qw - x * qx - y * qy - z * qz
    q[1] = w * qx + x * qw + y * qz - z * qy
    q[2] = w * qy - x * qz + y * qw + z * qx
    q[3] = w * qz + x * qy - y * qx + z * qw


@kernel(
    "void(f4[:,:,::1], f4[:,:,::1], f8[::1], f4[::1], f8[:,::1], i4[:,:,::1], f8[::1], f8, i8[:,::1], f4[:,:,::1],"
    " f4[:,::1], i4[::1], f4[::1], f4[:,:,::1], i8[::1])"
)
def blend_upper_bodies(
    position: Float32,
    rotation: Float32,
    beat: Float64,
    level: Float32,
    origin: Float64,
    limits: Int32,
    switch_beat: Float64,
    blend: float,
    signs: Int64,
    upper: Float32,
    offsets: Float32,
    parents: Int32,
    head: Float32,
    told: Float32,
    told_moment: Int64,
) -> None:
    """Blend texture into the upper bodies at `position` (A, J, 3) and `rotation` (A, J, 4), world, in place.

    `beat` (A,) is each dancer's beat. `level` (A,) is the weight of texture, 0 to 1. The current and the previous
    fragment are read at `origin` + PER_BEAT * danced (2, A), within `limits` (2, A, 2). They are cross-faded for
    `blend` beats from the beat `switch_beat` (A,). Joints whose bit is set in `signs` (2, A) are read with the opposite
    sign. `head` (A,) is the share of the head's turn to the audience, 0 to 1, which texture leaves unchanged. What
    `follow_legs` `told` (A, 3, 3 UPPER_COUNT) at the moments `told_moment` (A,) turns the recorded joints.
    """
    first = 1
    was = np.empty((UPPER_COUNT + 1, 4), np.float32)
    now, then, own = np.empty(4, np.float32), np.empty(4, np.float32), np.empty(4, np.float32)
    for a in range(position.shape[0]):
        if not level[a] > 0.0:
            continue
        for j in range(UPPER_COUNT + 1):
            for k in range(4):
                was[j, k] = rotation[a, j, k]
        u = min(max((beat[a] - switch_beat[a]) / blend, 0.0), 1.0)
        came = u * u * u * (u * (6.0 * u - 15.0) + 10.0)
        for n in range(UPPER_COUNT):
            joint = first + n
            parent = parents[joint]
            _read(now, upper, n, origin[0, a] + PER_BEAT * beat[a], limits[0, a, 0], limits[0, a, 1])
            _unit(now)
            if (signs[0, a] >> n) & 1:
                for k in range(4):
                    now[k] = -now[k]
            if came < 1.0:
                _read(then, upper, n, origin[1, a] + PER_BEAT * beat[a], limits[1, a, 0], limits[1, a, 1])
                _unit(then)
                if (signs[1, a] >> n) & 1:
                    for k in range(4):
                        then[k] = -then[k]
                _slerp_signed(now, then, now, came)
            _turn_as_told(now, told[a], n, 8.0 * beat[a] - told_moment[a])
            pw, px, py, pz = was[parent, 0], -was[parent, 1], -was[parent, 2], -was[parent, 3]
            qw, qx, qy, qz = was[joint, 0], was[joint, 1], was[joint, 2], was[joint, 3]
            own[0] = pw * qw - px * qx - py * qy - pz * qz
            own[1] = pw * qx + px * qw + py * qz - pz * qy
            own[2] = pw * qy - px * qz + py * qw + pz * qx
            own[3] = pw * qz + px * qy - py * qx + pz * qw
            share = float(level[a])
            if n == NECK_INDEX or n == NECK_INDEX + 1:
                share *= 1.0 - min(max(float(head[a]), 0.0), 1.0)
            _slerp_signed(own, own, now, share)
            _unit(own)
            pw, px, py, pz = (
                rotation[a, parent, 0],
                rotation[a, parent, 1],
                rotation[a, parent, 2],
                rotation[a, parent, 3],
            )
            qw, qx, qy, qz = own[0], own[1], own[2], own[3]
            rotation[a, joint, 0] = pw * qw - px * qx - py * qy - pz * qz
            rotation[a, joint, 1] = pw * qx + px * qw + py * qz - pz * qy
            rotation[a, joint, 2] = pw * qy - px * qz + py * qw + pz * qx
            rotation[a, joint, 3] = pw * qz + px * qy - py * qx + pz * qw
            vx, vy, vz = offsets[joint, 0], offsets[joint, 1], offsets[joint, 2]
            tx = np.float32(2.0) * (py * vz - pz * vy)
            ty = np.float32(2.0) * (pz * vx - px * vz)
            tz = np.float32(2.0) * (px * vy - py * vx)
            position[a, joint, 0] = position[a, parent, 0] + vx + pw * tx + py * tz - pz * ty
            position[a, joint, 1] = position[a, parent, 1] + vy + pw * ty + pz * tx - px * tz
            position[a, joint, 2] = position[a, parent, 2] + vz + pw * tz + px * ty - py * tx
