"""Quaternions (w, x, y, z) as numpy arrays (..., 4), with broadcasting, for offline work on clips.

Includes Euler angles in any order (BVH channels, T164), mean rotations, and scaling of rotations about a mean. The
frame loop uses the scalar kernels of `live.base.scalar_kernels` instead.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float

IDENTITY: Final = (1.0, 0.0, 0.0, 0.0)
_TINY: Final = 1e-12


def unit(vector: Float) -> Float:
    """Normalize vectors or quaternions (..., n); zero vectors stay zero."""
    length = np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.asarray(vector / np.maximum(length, _TINY))


def mul(a: Float, b: Float) -> Float:
    """Hamilton product a b, (..., 4): rotates by b first, then by a."""
    aw, ax, ay, az = np.moveaxis(np.asarray(a), -1, 0)
    bw, bx, by, bz = np.moveaxis(np.asarray(b), -1, 0)
    return np.stack(
        (
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ),
        axis=-1,
    )


def inverse(q: Float) -> Float:
    """Conjugate of unit quaternions, (..., 4)."""
    return np.asarray(q) * np.array((1.0, -1.0, -1.0, -1.0), np.asarray(q).dtype)


def rotate(q: Float, vector: Float) -> Float:
    """Vectors (..., 3) rotated by unit quaternions (..., 4)."""
    q, vector = np.asarray(q), np.asarray(vector)
    axis = q[..., 1:]
    axis, vector = np.broadcast_arrays(axis, vector)
    twice = 2.0 * np.cross(axis, vector)
    return np.asarray(vector + q[..., :1] * twice + np.cross(axis, twice))


def chain(
    parents: npt.NDArray[np.integer], translation: Sequence[Float] | Float, rotation: Float
) -> tuple[Float, Float]:
    """Return world positions (T, J, 3) and rotations (T, J, 4) of a chain of joints: B = A + O_B R_A and so on (T164).

    `translation` of each joint is (T, 3) or (3,), in its parent's axes; of a root (parent below 0) it is the world
    position. `rotation` (T, J, 4) is local. Parents come before their children. The results have the wider dtype.
    """
    frames, joints = rotation.shape[:2]
    dtype = np.result_type(rotation, *translation)
    positions, rotations = np.empty((joints, frames, 3), dtype), np.empty((joints, frames, 4), dtype)
    for joint, parent in enumerate(parents):
        if parent < 0:
            positions[joint], rotations[joint] = translation[joint], rotation[:, joint]
        else:
            positions[joint] = positions[parent] + rotate(rotations[parent], translation[joint])
            rotations[joint] = mul(rotations[parent], rotation[:, joint])
    return np.ascontiguousarray(positions.swapaxes(0, 1)), np.ascontiguousarray(rotations.swapaxes(0, 1))


def unchain(parents: npt.NDArray[np.integer], world: Float) -> Float:
    """Return unit rotations relative to the parents (T, J, 4), float64, from `world` rotations (T, J, 4)."""
    world = np.asarray(world, np.float64)
    rotation = world.copy()
    for joint, parent in enumerate(parents):
        if parent >= 0:
            rotation[:, joint] = mul(inverse(world[:, parent]), world[:, joint])
    return unit(rotation)


def slerp(a: Float, b: Float, t: Float) -> Float:
    """SLERP along the shorter arc, (..., 4); `t` (...) is 0 at a and 1 at b (the geodesic on S³, T045)."""
    a, b, t = np.asarray(a), np.asarray(b), np.asarray(t)
    dot = np.sum(a * b, axis=-1)
    sign = np.where(dot < 0.0, -1.0, 1.0)
    dot = np.minimum(np.abs(dot), 1.0)
    angle = np.arccos(dot)
    sine = np.sin(angle)
    near = sine < 1e-4  # small angle: use the chord, the sine is too small to divide by
    safe = np.where(near, 1.0, sine)
    weight_a = np.where(near, 1.0 - t, np.sin((1.0 - t) * angle) / safe)
    weight_b = np.where(near, t, np.sin(t * angle) / safe) * sign
    return unit(weight_a[..., None] * a + weight_b[..., None] * b)


def from_axis_angle(axis: Float, angle: Float) -> Float:
    """Rotation by `angle` [rad] (...) about `axis` (..., 3), of any length."""
    half = 0.5 * np.asarray(angle)[..., None]
    axis, half = np.broadcast_arrays(unit(np.asarray(axis)), half)
    return np.concatenate((np.cos(half[..., :1]), np.sin(half) * axis), axis=-1)


def from_rotation_vector(vector: Float) -> Float:
    """Rotation by |vector| [rad] about `vector` (..., 3): the exponential map."""
    vector = np.asarray(vector)
    half = 0.5 * np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.concatenate((np.cos(half), 0.5 * np.sinc(half / np.pi) * vector), axis=-1)


def to_rotation_vector(q: Float) -> Float:
    """Axis times angle [rad], at most pi long, (..., 3), of unit quaternions: the logarithm map."""
    q = np.where(np.asarray(q)[..., :1] < 0.0, -np.asarray(q), q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    scale = np.where(sine < 1e-9, 2.0, 2.0 * np.arctan2(sine, q[..., :1]) / np.maximum(sine, 1e-9))
    return np.asarray(scale * q[..., 1:])


def from_two_vectors(start: Float, end: Float) -> Float:
    """Shortest rotation from direction `start` (..., 3) to `end`; for opposite directions about any normal."""
    a, b = np.broadcast_arrays(unit(np.asarray(start)), unit(np.asarray(end)))
    dot = np.sum(a * b, axis=-1, keepdims=True)
    least = np.eye(3)[np.argmin(np.abs(a), axis=-1)]  # an axis that is not parallel to a
    turn = np.where(dot < -1.0 + 1e-9, np.cross(a, least), np.cross(a, b))
    return unit(np.concatenate((np.where(dot < -1.0 + 1e-9, 0.0, 1.0 + dot), turn), axis=-1))


def from_columns(x: Float, y: Float, z: Float) -> Float:
    """Rotation from the world axes to the orthonormal, right-handed x, y, z, each (..., 3) (Shepperd's method)."""
    m = np.stack((x, y, z), axis=-1)
    m00, m11, m22 = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    squares = np.stack((1 + m00 + m11 + m22, 1 + m00 - m11 - m22, 1 - m00 + m11 - m22, 1 - m00 - m11 + m22), -1)
    a, b, c = m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]
    d, e, f = m[..., 1, 0] + m[..., 0, 1], m[..., 2, 0] + m[..., 0, 2], m[..., 2, 1] + m[..., 1, 2]
    w, i, j, k = (squares[..., n] for n in range(4))
    candidates = np.stack(
        [np.stack(row, -1) for row in ((w, a, b, c), (a, i, d, e), (b, d, j, f), (c, e, f, k))], axis=-2
    )
    best = np.argmax(squares, axis=-1)
    return unit(np.take_along_axis(candidates, best[..., None, None], axis=-2)[..., 0, :])


def to_matrix(q: Float) -> Float:
    """Return rotation matrices (..., 3, 3) of unit quaternions."""
    w, x, y, z = np.moveaxis(np.asarray(q), -1, 0)
    rows = (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def align_signs(q: Float) -> Float:
    """The same rotations (T, ..., 4) with signs chosen so that each is nearest to its predecessor along axis 0."""
    q = np.asarray(q)
    flips = np.where(np.sum(q[1:] * q[:-1], axis=-1) < 0.0, -1.0, 1.0)
    signs = (
        np.concatenate((np.ones_like(flips[:1]), np.cumprod(flips, axis=0))) if len(q) > 1 else np.ones(q.shape[:-1])
    )
    return np.asarray(q * signs[..., None])


def euler_to_quaternion(angles: Float, order: str) -> Float:
    """Return unit quaternions (..., 4) of rotations about the axes in `order`, one angle each, (..., n) [rad].

    `order` follows BVH channels: "ZXY" rotates the child by R = Rz Rx Ry (column vectors), first about y, then about
    the x and the z of the parent. Any number of axes from "XYZ" is allowed, with repetition; "" gives the identity.
    """
    half = 0.5 * np.asarray(angles, np.float64)
    if half.shape[-1] != len(order):
        raise ValueError(f"{half.shape[-1]} angles for the axes {order!r}")
    result = np.zeros((*half.shape[:-1], 4))
    result[..., 0] = 1.0
    cosine, sine = np.cos(half), np.sin(half)
    for place, axis in enumerate(order):
        k = 1 + "XYZ".index(axis)
        i, j = k % 3 + 1, (k + 1) % 3 + 1  # the next axes in cyclic order x, y, z
        c, s = cosine[..., place], sine[..., place]
        w, along, first, second = (result[..., n].copy() for n in (0, k, i, j))
        result[..., 0] = w * c - along * s
        result[..., k] = along * c + w * s
        result[..., i] = first * c + second * s
        result[..., j] = second * c - first * s
    return result


_FADE: Final = np.radians((150.0, 180.0))
"""Between these distances from the mean the scaling fades out: at half a turn there is no shorter direction."""


def mean_rotation(rotation: Float) -> Float:
    """Return the mean (..., 4) of rotations (T, ..., 4): the eigenvector of the largest eigenvalue of Σ q qᵀ.

    It minimises the sum of squared chordal distances and is independent of the quaternions' signs (Markley et al.,
    Averaging quaternions, 2007). w is not negative.
    """
    q = np.moveaxis(np.asarray(rotation, np.float64), 0, -2)
    _, vectors = np.linalg.eigh(np.swapaxes(q, -1, -2) @ q)
    mean = vectors[..., -1]
    return np.asarray(mean * np.where(mean[..., :1] < 0.0, -1.0, 1.0))


def scale_about_mean(mean: Float, rotation: Float, factor: npt.ArrayLike) -> Float:
    """Return mean · (mean⁻¹ q) ^ factor for rotations q (..., 4) (T058); where `factor` (...) is 1, q is unchanged.

    The power scales the angle along the shorter arc from the mean. Between 150 and 180 degrees the factor fades to 1,
    because at 180 there is no shorter arc; no body joint turns that far.
    """
    rotation = np.asarray(rotation, np.float64)
    factor = np.asarray(factor, np.float64)
    away = mul(inverse(mean), rotation)
    away = away * np.where(away[..., :1] < 0.0, -1.0, 1.0)
    sine = np.linalg.norm(away[..., 1:], axis=-1)
    angle = 2.0 * np.arctan2(sine, away[..., 0])
    fade = 1.0 - np.clip((angle - _FADE[0]) / (_FADE[1] - _FADE[0]), 0.0, 1.0)
    scaled = from_axis_angle(away[..., 1:], angle * (1.0 + (factor - 1.0) * fade))
    result = mul(mean, scaled)
    result = result * np.where(np.sum(result * rotation, axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    untouched = np.broadcast_to(factor == 1.0, result.shape[:-1]) | (sine < 1e-12)
    return np.asarray(np.where(untouched[..., None], rotation, result))
