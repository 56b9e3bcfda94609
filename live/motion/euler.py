"""Euler angles in any order to quaternions: what BVH channels mean (T164)."""

import numpy as np
import numpy.typing as npt

Float = npt.NDArray[np.floating]


def euler_to_quaternion(angles: Float, order: str) -> Float:
    """Unit quaternions (..., 4) of the rotations about the axes named in `order`, one angle each, (..., n) [rad].

    `order` is read as BVH reads its channels: "ZXY" turns the child by R = Rz Rx Ry (column vectors), that is first
    about y, then about the x and the z of the parent. Any number of axes from "XYZ" may be named, also one twice;
    "" gives the identity.
    """
    half = 0.5 * np.asarray(angles, np.float64)
    if half.shape[-1] != len(order):
        raise ValueError(f"{half.shape[-1]} angles for the axes {order!r}")
    result = np.zeros((*half.shape[:-1], 4))
    result[..., 0] = 1.0
    cosine, sine = np.cos(half), np.sin(half)
    for place, axis in enumerate(order):
        k = 1 + "XYZ".index(axis)
        i, j = k % 3 + 1, (k + 1) % 3 + 1  # the next axes in the circle x, y, z
        c, s = cosine[..., place], sine[..., place]
        w, along, first, second = (result[..., n].copy() for n in (0, k, i, j))
        result[..., 0] = w * c - along * s
        result[..., k] = along * c + w * s
        result[..., i] = first * c + second * s
        result[..., j] = second * c - first * s
    return result
