"""How far dancers have drifted ahead or behind, in one pass (T056)."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.base.scalar_kernels import ease

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]


@kernel("f8(i8, f8[::1], f8[::1], f8[::1], f8[:,:,::1], f8[::1])")
def drifted(n: int, value: Float64, passed: Float64, phase: Float64, knots: Float64, most: Float64) -> float:
    """How far dancer `n` is ahead [share of a measure]: A(x) sin φ(x), see `Drift.at`."""
    if most[n] == 0.0:
        return 0.0
    amplitude = turned = 0.0
    for k in range(4):
        amplitude += value[k] * knots[0, k, n]
        turned += passed[k] * knots[1, k, n]
    return float(most[n] * amplitude * math.sin(phase[n] + 2.0 * math.pi * turned))


@kernel("void(f8[::1], i8[::1], f8, f8[::1], f8[:,:,::1], f8[::1], i4[::1], i4[::1])")
def drift_ahead(
    out: Float64, rows: Int64, fraction: float, phase: Float64, knots: Float64, most: Float64, liked: Int32, like: Int32
) -> None:
    """How far the dancers `rows` (n,) are ahead at `fraction` of the measure [share of a measure], `out` (n,).

    `phase` (A,) [rad] when the measure begins, `knots` (2, 4, A) of amplitude and frequency, `most` (A,) how far each
    may drift. Through the measure each goes over from the timing of `liked` (A,) to that of `like` (A,).
    """
    t = fraction
    value, passed = np.empty(4), np.empty(4)
    value[0], value[1] = (1 - t) ** 3 / 6.0, (3 * t**3 - 6 * t**2 + 4) / 6.0
    value[2], value[3] = (-3 * t**3 + 3 * t**2 + 3 * t + 1) / 6.0, t**3 / 6.0
    passed[0], passed[1] = (1 - (1 - t) ** 4) / 24.0, (3 * t**4 - 8 * t**3 + 16 * t) / 24.0
    passed[2], passed[3] = (-3 * t**4 + 4 * t**3 + 6 * t**2 + 4 * t) / 24.0, t**4 / 24.0
    share = ease(fraction)
    for i in range(rows.shape[0]):
        before, after = liked[rows[i]], like[rows[i]]
        ahead = drifted(before, value, passed, phase, knots, most)
        if after != before:
            ahead += share * (drifted(after, value, passed, phase, knots, most) - ahead)
        out[i] = ahead
