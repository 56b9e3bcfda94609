"""How much room ways out of a collision lack to all who are near, in one pass."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float64 = npt.NDArray[np.float64]


@kernel("void(f8[::1], f8[:,:,::1], f8[:,:,::1], f8)")
def find_lacks(out: Float64, ways: Float64, others: Float64, margin: float) -> None:
    """What each of `ways` (W, C, 2) lacks of `margin` to the `others` (M, W, 3), x, z, nearest distance [m].

    At the worst of its W moments and on the average of them, added: `out` (C,).
    """
    moments = ways.shape[0]
    for c in range(ways.shape[1]):
        worst, total = 0.0, 0.0
        for w in range(moments):
            lack = 0.0
            for m in range(others.shape[0]):
                away = math.hypot(ways[w, c, 0] - others[m, w, 0], ways[w, c, 1] - others[m, w, 1]) - others[m, w, 2]
                lack = max(lack, margin - away)
            worst = max(worst, lack)
            total += lack
        out[c] = worst + total / moments
