"""The mean of rotations, and a rotation taken farther from it or nearer to it."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion

Float = npt.NDArray[np.floating]

_FADE: Final = np.radians((150.0, 180.0))
"""Rotations this far from the mean are scaled less and less: at half a turn both ways round are the same place."""


def mean_rotation(rotation: Float) -> Float:
    """Mean (..., 4) of rotations (T, ..., 4): the eigenvector of the largest eigenvalue of Σ q qᵀ.

    It minimises the sum of squared chordal distances and does not care for the signs of quaternions (Markley et al.,
    Averaging quaternions, 2007). w is not negative.
    """
    q = np.moveaxis(np.asarray(rotation, np.float64), 0, -2)
    _, vectors = np.linalg.eigh(np.swapaxes(q, -1, -2) @ q)
    mean = vectors[..., -1]
    return np.asarray(mean * np.where(mean[..., :1] < 0.0, -1.0, 1.0))


def scale_from(mean: Float, rotation: Float, factor: npt.ArrayLike) -> Float:
    """mean · (mean⁻¹ q) ^ factor, for rotations q (..., 4) (T058): what is 1 in `factor` (...) stays as it is.

    The power scales the angle of the shorter way from the mean. Beyond 150 degrees the factor fades to 1 at 180,
    where there is no shorter way; no joint of a body swings so far.
    """
    rotation = np.asarray(rotation, np.float64)
    factor = np.asarray(factor, np.float64)
    away = quaternion.mul(quaternion.inverse(mean), rotation)
    away = away * np.where(away[..., :1] < 0.0, -1.0, 1.0)
    sine = np.linalg.norm(away[..., 1:], axis=-1)
    angle = 2.0 * np.arctan2(sine, away[..., 0])
    fade = 1.0 - np.clip((angle - _FADE[0]) / (_FADE[1] - _FADE[0]), 0.0, 1.0)
    scaled = quaternion.from_axis_angle(away[..., 1:], angle * (1.0 + (factor - 1.0) * fade))
    result = quaternion.mul(mean, scaled)
    result = result * np.where(np.sum(result * rotation, axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    untouched = np.broadcast_to(factor == 1.0, result.shape[:-1]) | (sine < 1e-12)
    return np.asarray(np.where(untouched[..., None], rotation, result))
