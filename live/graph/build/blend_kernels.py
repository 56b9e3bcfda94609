"""Blend kernels: distance of the rotations of two clips while one passes into the other."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]


@kernel("void(f4[:,:,:,::1], f4[:,:,:,::1], i4[::1], i4[::1], f8[::1], f8[::1], f8, f8, b1[::1])")
def find_blendable(
    end: Float32, start: Float32, source: Int32, target: Int32, yaw: Float64, weight: Float64,
    min_root_cosine: float, min_chord: float, out: Bool,
) -> None:  # fmt: skip
    """Write which of E joins `source` -> `target` (E,) can be blended into `out` (E,).

    `end` and `start` (N, K, J, 4): local rotations at K moments of the blend, of the measure that ends and of the one
    that begins; `weight` (K,) of the latter; `yaw` (E,) [rad] turns the target's clip into the source's axes. The root
    takes the shorter arc and must not be so far away that the arc could change sides: |cos| of half the angle is at
    least `min_root_cosine`. The other joints are mixed by their signs; the mixture must stay longer than `min_chord`,
    because it turns round suddenly near 0.
    """
    for e in range(source.shape[0]):
        u, v = source[e], target[e]
        c, s = math.cos(0.5 * yaw[e]), math.sin(0.5 * yaw[e])
        good = True
        for k in range(end.shape[1]):
            a, b = end[u, k, 0], start[v, k, 0]
            dot = a[0] * (c * b[0] - s * b[2]) + a[1] * (c * b[1] + s * b[3])
            dot += a[2] * (c * b[2] + s * b[0]) + a[3] * (c * b[3] - s * b[1])
            good = good and abs(dot) >= min_root_cosine
            w = weight[k]
            for j in range(1, end.shape[2]):
                p, q = end[u, k, j], start[v, k, j]
                dot = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3]
                square = (1.0 - w) * (1.0 - w) + w * w + 2.0 * w * (1.0 - w) * dot
                good = good and square >= min_chord * min_chord
            if not good:
                break
        out[e] = good
