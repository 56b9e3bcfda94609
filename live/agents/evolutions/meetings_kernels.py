"""How many pairs of dancers come too near to each other; of no pair it is known how near."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float64 = npt.NDArray[np.float64]
Float32 = npt.NDArray[np.float32]

APART = 0.01
"""Who is so much [m] more than clear of another has not met her yet, whatever rounding does."""


@kernel("void(f4[:,:,::1], f8[::1])")
def longest_steps(ways: Float32, step: Float64) -> None:
    """How far each dancer on `ways` (D, T, 2) [m] goes at most from one time to the next, `step` (D,) [m]."""
    for d in range(ways.shape[0]):
        longest = 0.0
        for k in range(1, ways.shape[1]):
            x, z = float(ways[d, k, 0]) - ways[d, k - 1, 0], float(ways[d, k, 1]) - ways[d, k - 1, 1]
            longest = max(longest, x * x + z * z)
        step[d] = math.sqrt(longest)


@kernel("b1(f4[:,:,::1], i8, i8, f4, f8)")
def meet(ways: Float32, i: int, j: int, clear: float, step: float) -> bool:
    """Whether two of the dancers on `ways` (D, T, 2) [m], at even times and linear between, come nearer than `clear`.

    As `nearest_approach` measures it, but only as far as the first time; and since the two approach each other by
    `step` [m] at most from one time to the next, times in which they cannot have met are left out.
    """
    x0, z0 = float(ways[j, 0, 0]) - ways[i, 0, 0], float(ways[j, 0, 1]) - ways[i, 0, 1]
    if np.float32(math.sqrt(x0 * x0 + z0 * z0)) < clear:
        return True
    surely = (float(clear) + APART) ** 2  # a root is only taken near the bound
    k = 1
    while k < ways.shape[1]:
        away = math.sqrt(x0 * x0 + z0 * z0) - clear - APART
        if away > step:
            k += int(min(away / max(step, 1e-9), float(ways.shape[1])))
            if k >= ways.shape[1]:
                return False
            x0, z0 = float(ways[j, k - 1, 0]) - ways[i, k - 1, 0], float(ways[j, k - 1, 1]) - ways[i, k - 1, 1]
        x1, z1 = float(ways[j, k, 0]) - ways[i, k, 0], float(ways[j, k, 1]) - ways[i, k, 1]
        dx, dz = x1 - x0, z1 - z0
        square = dx * dx + dz * dz
        u = 1.0
        if square > 1e-18:
            u = min(max(-(x0 * dx + z0 * dz) / square, 0.0), 1.0)
        px, pz = x0 + u * dx, z0 + u * dz
        gap = px * px + pz * pz
        if gap < surely and np.float32(math.sqrt(gap)) < clear:
            return True
        x0, z0 = x1, z1
        k += 1
    return False


@kernel("i8(f4[:,:,::1], f8[::1], i8, i8, f4)")
def count_meetings(ways: Float32, step: Float64, first: int, last: int, clear: float) -> int:
    """How many of the dancers `first` to `last` (not included) come nearer than `clear` [m] to how many after them.

    `ways` as in `meet`, `step` (D,) [m] by `longest_steps`.
    """
    meeting = 0
    for i in range(first, last):
        for j in range(i + 1, ways.shape[0]):
            meeting += meet(ways, i, j, clear, step[i] + step[j])
    return meeting
