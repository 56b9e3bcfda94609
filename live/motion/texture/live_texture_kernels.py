"""Kernels of live texturing: which fragment matches the legs' prefix, and upper bodies dressed with what was chosen."""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]

PER_BEAT: Final = 16
"""Samples of a bank in a beat."""
SLOTS: Final = 7
"""Moments at which legs are compared: every eighth beat, from half a beat before a beat line to a quarter after."""
FEATURES: Final = 12
"""Numbers that tell where both knees and ankles are."""
DERIVATIVE: Final = 2.0
"""Weight of how legs move, from one of the moments to the next, against where they are."""
DIMENSIONS: Final = (2 * SLOTS - 1) * FEATURES
"""Numbers by which beats are compared: where knees and ankles are at all moments, and how that changes."""
UPPER_COUNT: Final = 13
"""Joints of the upper body: those after the hips, one after the other, the first of which is 1."""
HEAD_FROM: Final = 3
"""Of these the neck and the head are HEAD_FROM and the next."""


@kernel("void(f4[:,::1], f4[:,:,::1], f4[:,:,::1])")
def watch_legs(out: Float32, position: Float32, rotation: Float32) -> None:
    """Knees and ankles in the axes of the hips, (A, FEATURES), of legs at `position` and `rotation` (A, 9, 3 or 4).

    Joints are hips, then thigh, shin, foot and toes of the left and of the right leg, in the world.
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
def keep_moments(
    kept: Float32, before: Float32, now: Float32, danced_before: Float64, danced: Float64, per_beat: int
) -> None:
    """Keep where legs were at every 1 / `per_beat` beat that was passed since the last tick: `kept` (A, slots, n).

    `before` and `now` (A, n) are what was watched then and now, at the danced beats `danced_before` and `danced` (A,);
    between them legs went straight.
    """
    slots = kept.shape[1]
    for a in range(kept.shape[0]):
        way = danced[a] - danced_before[a]
        first, last = math.floor(danced_before[a] * per_beat) + 1, math.floor(danced[a] * per_beat)
        if not way > 0.0 or last - first >= slots:
            first = last
        for moment in range(first, last + 1):
            part = 1.0
            if way > 0.0:
                part = min(max((moment / per_beat - danced_before[a]) / way, 0.0), 1.0)
            for n in range(kept.shape[2]):
                kept[a, int(moment % slots), n] = before[a, n] + part * (now[a, n] - before[a, n])


@kernel("i8(i8,i8,i8)")
def mixed(seed: int, dancer: int, fragment: int) -> int:
    """A number of 24 bits that these three make, like chance."""
    value = (seed * 0x9E3779B1 + dancer * 0x85EBCA6B + fragment * 0xC2B2AE35) & 0xFFFFFFFF
    value = ((value ^ (value >> 15)) * 0x2C1B3C6D) & 0xFFFFFFFF
    value = ((value ^ (value >> 12)) * 0x297A2D39) & 0xFFFFFFFF
    return (value ^ (value >> 15)) >> 8


@kernel("void(f4[::1], f4[:,::1], i8)")
def prefix_of(own: Float32, kept: Float32, line: int) -> None:
    """What is compared of legs about the beat `line`, into `own` (D,), of what was `kept` (moments, FEATURES) of them:
    where knees and ankles were at SLOTS moments, then how that changed, as `compared` of the bank has it."""
    moments = kept.shape[0]
    for slot in range(SLOTS):
        row = int((8 * line + slot - SLOTS // 2 - 1) % moments)
        for n in range(FEATURES):
            own[slot * FEATURES + n] = kept[row, n]
    for n in range((SLOTS - 1) * FEATURES):
        own[SLOTS * FEATURES + n] = np.float32(DERIVATIVE) * (own[n + FEATURES] - own[n])


@kernel("i8(f4[::1], f4[:,::1], f4[::1], i8, f8, f8, i8, i8)")
def nearest_fragment(
    far: Float32, legs: Float32, own: Float32, going: int, join: float, taste: float, seed: int, dancer: int
) -> int:
    """The fragment, of F, whose legs are most like `own` (D,); `legs` is (D, F), `far` (F,) is scratch.

    Every fragment but the one that is `going` on (-1: none) costs `join` more. Distances count up to (1 + `taste`)
    times as much, for each dancer and fragment by chance: so each dancer has fragments she likes.
    """
    count = far.shape[0]
    for f in range(count):
        far[f] = 0.0
    for d in range(legs.shape[0]):
        value = own[d]
        for f in range(count):
            away = legs[d, f] - value
            far[f] += away * away
    best, least = 0, np.inf
    for f in range(count):
        cost = float(far[f]) * (1.0 + taste * mixed(seed, dancer, f) / 16777216.0)
        if f != going:
            cost += join
        if cost < least:
            best, least = f, cost
    return best


@kernel("void(f4[::1], f4[:,:,::1], i8, f8, i8, i8)")
def _read(out: Float32, upper: Float32, joint: int, sample: float, first: int, last: int) -> None:
    """The rotation of a joint at a fractional `sample`: the cubic through four neighbours, not unit."""
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
    """Make `q` as long as 1; what has no length is no rotation."""
    size = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    if size < 1e-6:
        q[0], size = 1.0, 1.0
    scale = np.float32(1.0 / size)
    for k in range(4):
        q[k] *= scale


@kernel("i8(f4[:,:,::1], f8, i4[::1], f8, i4[::1], i8, f4[:,::1], b1)")
def signs_of(
    upper: Float32, here: float, limits: Int32, there: float, other: Int32, known: int, middle: Float32, whole: bool
) -> int:
    """For which joints, a bit each, the sample `here` is to be read with the opposite sign, from now on.

    If texture is the `whole` of what is seen, so that the way from the sample `there`, read with the signs `known`, is
    the shorter one; else so that the way from the `middle` is, about which steps are, too.
    """
    a, b = np.empty(4, np.float32), np.empty(4, np.float32)
    bits = 0
    for n in range(UPPER_COUNT):
        _read(a, upper, n, here, limits[0], limits[1])
        sign = np.float32(1.0)
        if whole:
            _read(b, upper, n, there, other[0], other[1])
            if (known >> n) & 1:
                sign = np.float32(-1.0)
        else:
            for k in range(4):
                b[k] = middle[n, k]
        if sign * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]) < 0.0:
            bits |= 1 << n
    return bits


@kernel("void(f4[::1], f4[::1], f4[::1], f8)")
def _between(out: Float32, a: Float32, b: Float32, share: float) -> None:
    """From the unit quaternion `a` so far to `b`, at an even speed: the way of their signs, not the shorter one.

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


@kernel(
    "void(f4[:,:,::1], f4[:,:,::1], f8[::1], f4[::1], f8[:,::1], i4[:,:,::1], f8[::1], f8, i8[:,::1], f4[:,:,::1],"
    " f4[:,::1], i4[::1], f4[::1])"
)
def dress(
    position: Float32,
    rotation: Float32,
    danced: Float64,
    level: Float32,
    origin: Float64,
    limits: Int32,
    switched: Float64,
    blend: float,
    signs: Int64,
    upper: Float32,
    offsets: Float32,
    parents: Int32,
    head: Float32,
) -> None:
    """Upper bodies of dancers at `position` (A, J, 3) and `rotation` (A, J, 4), world, given their textures.

    `danced` (A,): the beat each dancer is at; `level` (A,): 0 as danced, 1 all texture. What she has, and what she had
    before, is read at `origin` + PER_BEAT * danced (2, A), within `limits` (2, A, 2); from `switched` (A,), a beat, on
    the one comes in for the other within `blend` beats; joints whose bit is set in `signs` (2, A) are read
    with the opposite sign. `head` (A,): how far heads turn to the public, who keep that.
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
        u = min(max((danced[a] - switched[a]) / blend, 0.0), 1.0)
        came = u * u * u * (u * (6.0 * u - 15.0) + 10.0)
        for n in range(UPPER_COUNT):
            joint = first + n
            parent = parents[joint]
            _read(now, upper, n, origin[0, a] + PER_BEAT * danced[a], limits[0, a, 0], limits[0, a, 1])
            _unit(now)
            if (signs[0, a] >> n) & 1:
                for k in range(4):
                    now[k] = -now[k]
            if came < 1.0:
                _read(then, upper, n, origin[1, a] + PER_BEAT * danced[a], limits[1, a, 0], limits[1, a, 1])
                _unit(then)
                if (signs[1, a] >> n) & 1:
                    for k in range(4):
                        then[k] = -then[k]
                _between(now, then, now, came)
            pw, px, py, pz = was[parent, 0], -was[parent, 1], -was[parent, 2], -was[parent, 3]
            qw, qx, qy, qz = was[joint, 0], was[joint, 1], was[joint, 2], was[joint, 3]
            own[0] = pw * qw - px * qx - py * qy - pz * qz
            own[1] = pw * qx + px * qw + py * qz - pz * qy
            own[2] = pw * qy - px * qz + py * qw + pz * qx
            own[3] = pw * qz + px * qy - py * qx + pz * qw
            share = float(level[a])
            if n == HEAD_FROM or n == HEAD_FROM + 1:
                share *= 1.0 - min(max(float(head[a]), 0.0), 1.0)
            _between(own, own, now, share)
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
