"""Rotations one by one, as quaternions (w, x, y, z) in double precision: parts for kernels of captured bodies.

Their loops run over the 22 joints of few dancers, so there are no blocks.
"""

import math
from typing import Any

from live.base.jit import part

Vector = tuple[float, float, float]
Rotation = tuple[float, float, float, float]


@part
def times(a: Rotation, b: Rotation) -> Rotation:
    """First b, then a."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


@part
def turn_vector(q: Rotation, x: float, y: float, z: float) -> Vector:
    """The vector turned by q."""
    tx, ty, tz = 2.0 * (q[2] * z - q[3] * y), 2.0 * (q[3] * x - q[1] * z), 2.0 * (q[1] * y - q[2] * x)
    return (
        x + q[0] * tx + q[2] * tz - q[3] * ty,
        y + q[0] * ty + q[3] * tx - q[1] * tz,
        z + q[0] * tz + q[1] * ty - q[2] * tx,
    )


@part
def inverse(q: Rotation) -> Rotation:
    """The turn back."""
    return q[0], -q[1], -q[2], -q[3]


@part
def shortest_turn(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> Rotation:
    """The shortest turn that brings direction a to direction b; none at all where they are opposite."""
    scale = 1.0 / math.sqrt((ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz))
    w = 1.0 + (ax * bx + ay * by + az * bz) * scale
    x, y, z = (ay * bz - az * by) * scale, (az * bx - ax * bz) * scale, (ax * by - ay * bx) * scale
    size = math.sqrt(w * w + x * x + y * y + z * z)
    if size < 1e-6:
        return 1.0, 0.0, 0.0, 0.0
    return w / size, x / size, y / size, z / size


@part
def mix(a: Rotation, b: Rotation, t: float) -> Rotation:
    """From a to b by the shorter way, at the share t of it: the chord, made a rotation again."""
    sign = 1.0 if a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] >= 0.0 else -1.0
    w, x = a[0] + t * (sign * b[0] - a[0]), a[1] + t * (sign * b[1] - a[1])
    y, z = a[2] + t * (sign * b[2] - a[2]), a[3] + t * (sign * b[3] - a[3])
    size = math.sqrt(w * w + x * x + y * y + z * z)
    if size < 1e-9:
        return a
    return w / size, x / size, y / size, z / size


@part
def heading(q: Rotation) -> float:
    """How far q turns about the vertical [rad]: its twist."""
    return 2.0 * math.atan2(q[2], q[0])


@part
def _logarithm(q: Rotation) -> Vector:
    """The logarithm of q: axis times half the angle."""
    sine = math.sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    sign = 1.0 if q[0] >= 0.0 else -1.0
    scale = sign * math.atan2(sine, abs(q[0])) / sine if sine > 1e-9 else sign
    return q[1] * scale, q[2] * scale, q[3] * scale


@part
def through_rest(a: Rotation, b: Rotation, t: float) -> Rotation:
    """Between a and b by their turns from the rest pose.

    The shorter way from one to the other may be the other way round a moment later, and then a limb would jump; but no
    joint turns half round from its rest pose.
    """
    ax, ay, az = _logarithm(a)
    bx, by, bz = _logarithm(b)
    x, y, z = ax + t * (bx - ax), ay + t * (by - ay), az + t * (bz - az)
    half = math.sqrt(x * x + y * y + z * z)
    scale = math.sin(half) / half if half > 1e-9 else 1.0
    return math.cos(half), x * scale, y * scale, z * scale


@part
def row_of(rows: Any, n: int) -> Rotation:
    """Row n of `rows` (N, 4)."""
    return rows[n, 0], rows[n, 1], rows[n, 2], rows[n, 3]


@part
def about_vertical(angle: float) -> Rotation:
    """The turn by `angle` [rad] about the vertical."""
    return math.cos(0.5 * angle), 0.0, math.sin(0.5 * angle), 0.0
