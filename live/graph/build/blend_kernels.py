"""Blend kernels: distance of the rotations of two clips while one passes into the other."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
UInt8 = npt.NDArray[np.uint8]

NOT_ASKED = 2
"""Contact of a measure that may be blended with any."""


@kernel("b1(f4[:,:,::1], f4[:,:,::1], f8, f8[::1], u1[:,::1], u1[:,::1], f8, f8)")
def is_blendable(
    end: Float32, start: Float32, yaw: float, weight: Float64, end_stands: UInt8, start_stands: UInt8,
    min_root_cosine: float, min_chord: float,
) -> bool:  # fmt: skip
    """Whether a measure can be followed by another: no joint spins in the blend, and there is a foot to stand on.

    `end` and `start` (K, J, 4): local rotations at K moments of the blend, of the measure that ends and of the one that
    begins; `weight` (K,) of the latter; `yaw` [rad] turns the second clip into the first one's axes. The root takes the
    shorter arc and must not be so far away that the arc could change sides: |cos| of half the angle is at least
    `min_root_cosine`. The other joints are mixed by their signs; the mixture must stay longer than `min_chord`, because
    it turns round suddenly near 0. `end_stands` and `start_stands` (K, 2): 1 for a foot on the floor, NOT_ASKED for
    sketched measures. Somewhere in the blend a foot must stand in both measures, or both must be in the air: else the
    dancer would float from one foot to the other, or out of a jump onto the floor.
    """
    common = False
    for k in range(end.shape[0]):
        a, b = end_stands[k], start_stands[k]
        common |= a[0] == NOT_ASKED or b[0] == NOT_ASKED or (a[0] and b[0]) or (a[1] and b[1])
        common |= not (a[0] or a[1] or b[0] or b[1])
    if not common:
        return False
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
