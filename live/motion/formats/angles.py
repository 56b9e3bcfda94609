"""Quaternions as the angles of BVH channels: z, x, y in turn, smooth from frame to frame (T164)."""

import numpy as np
import numpy.typing as npt

from live.motion import quaternion

Float = npt.NDArray[np.floating]
Float64 = npt.NDArray[np.float64]

_LOCKED = 1e-9
"""Cosine of x below which z and y turn about one axis, and only their sum or difference is known."""


def zxy_angles(rotation: Float) -> Float64:
    """Angles about z, x and y [rad] of unit quaternions, (..., 4) → (..., 3): R = Rz Rx Ry, x within ±90 degrees."""
    w, x, y, z = np.moveaxis(quaternion.unit(np.asarray(rotation, np.float64)), -1, 0)
    minus_sin_z, cos_z = 2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z)  # both times cos x
    minus_sin_y, cos_y = 2.0 * (x * z - w * y), 1.0 - 2.0 * (x * x + y * y)  # both times cos x
    cos_x = np.hypot(minus_sin_z, cos_z)
    locked = cos_x < _LOCKED
    about_y = np.where(
        locked,
        np.arctan2(2.0 * (x * z + w * y), 1.0 - 2.0 * (y * y + z * z)),
        np.arctan2(-minus_sin_y, cos_y),
    )
    about_z = np.where(locked, 0.0, np.arctan2(-minus_sin_z, cos_z))
    return np.stack((about_z, np.arctan2(2.0 * (y * z + w * x), cos_x), about_y), axis=-1)


def smooth_angles(angles: Float64) -> Float64:
    """The same rotations (T, ..., 3) with each frame's angles nearest to those of the frame before.

    A rotation has two triples (z, x, y) and (z + π, π - x, y + π), each up to whole turns; programs that interpolate
    the channels themselves would otherwise whirl between two frames.
    """
    result = angles.copy()
    turn = 2.0 * np.pi
    for frame in range(1, len(angles)):
        first = angles[frame]
        second = np.stack((first[..., 0] + np.pi, np.pi - first[..., 1], first[..., 2] + np.pi), axis=-1)
        before = result[frame - 1]
        near = [triple + turn * np.round((before - triple) / turn) for triple in (first, second)]
        ways = [np.abs(triple - before).sum(axis=-1, keepdims=True) for triple in near]
        result[frame] = np.where(ways[0] <= ways[1], near[0], near[1])
    return result
