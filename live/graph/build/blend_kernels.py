"""Blend kernels: distance of the rotations of two clips while one passes into the other."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]


@kernel("b1(f4[:,:,::1], f4[:,:,::1], f8, f8[::1], f8, f8)")
def is_blendable(
    end: Float32, start: Float32, yaw: float, weight: Float64, min_root_cosine: float, min_chord: float
) -> bool:
    """Whether a measure can be followed by another without a joint that spins in the blend.

    `end` and `start` (K, J, 4): local rotations at K moments of the blend, of the measure that ends and of the one that
    begins; `weight` (K,) of the latter; `yaw` [rad] turns the second clip into the first one's axes. The root takes the
    shorter arc and must not be so far away that the arc could change sides: |cos| of half the angle is at least
    `min_root_cosine`. The other joints are mixed by their signs; the mixture must stay longer than `min_chord`, because
    it turns round suddenly near 0.
    """
    c, s = math.cos(0.5 * yaw), math.sin(0.5 * yaw)
    for k in range(end.shape[0]):
        a, b = end[k, 0], start[k, 0]
        dot = a[0] * (c * b[0] - s * b[2]) + a[1] * (c * b[1] + s * b[3])
        dot += a[2] * (c * b[2] + s * b[0]) + a[3] * (c * b[3] - s * b[1])
        if abs(dot) < min_root_cosine:
            return False
        w = weight[k]
        for j in range(1, end.shape[1]):
            p, q = end[k, j], start[k, j]
            dot = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3]
            square = (1.0 - w) * (1.0 - w) + w * w + 2.0 * w * (1.0 - w) * dot
            if square < min_chord * min_chord:
                return False
    return True
