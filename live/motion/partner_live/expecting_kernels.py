"""Where a follower is to be expected in a frame, from all units that run.

Times are frames; rings of R frames, row t % R.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel, part
from live.motion.partner_live.finishing_kernels import turn_of

Float64 = npt.NDArray[np.float64]
Complex128 = npt.NDArray[np.complex128]
Int64 = npt.NDArray[np.int64]

LATE: Any = 0.1
"""By this share of its length a unit may be over that still says where the follower is."""
FAR: Any = 8.0
"""Units that weigh less than e to the minus this are left out."""


@part
def _root_at(root: Complex128, facing: Complex128, first: int, stop: int, place: float) -> Any:
    """Where a recording's hips are on the floor and where they face at the sample `place` of it."""
    place = min(max(place, 0.0), float(stop - first - 1))
    low = min(int(place), max(stop - first - 2, 0))
    w = place - low
    one, other = first + low, min(first + low + 1, stop - 1)
    return (1.0 - w) * root[one] + w * root[other], (1.0 - w) * facing[one] + w * facing[other]


@kernel(
    "i8(f8,f8,i8,c16[:,::1],c16[::1],c16[::1],i8[::1],i8[::1],f8[::1],f8[::1],f8[:,::1],c16[:,:,::1],c16[::1],f8[:,::1],"
    "f8[:,::1],c16[::1])"
)
def expect_root(
    spread: float,
    fewest: float,
    at: int,
    x: Complex128,
    root: Complex128,
    facing: Complex128,
    record_first: Int64,
    record_stop: Int64,
    start: Float64,
    length: Float64,
    step: Float64,
    sums: Complex128,
    input_sum: Complex128,
    frames: Float64,
    value: Float64,
    found: Complex128,
) -> int:
    """Where the follower's hips are to be expected at frame `at`: the mean over all units that run, how many of them.

    Only boundaries of which `fewest` frames are seen count: fewer say nothing of where a unit lies. A unit whose score
    `value` (R, N) is worse than the best by v [m²] weighs exp(-v / spread). root and facing (S,): of
    the followers in all recordings; length (N,) [samples] of the units, the others as in `score_running`. found (2,):
    the place and, of any length, the facing; it is left alone where nothing runs.
    """
    ring, points = x.shape
    best = np.inf
    for row in range(ring):
        if frames[row, 0] < fewest:
            continue
        for unit in range(start.shape[0]):
            if (frames[row, 0] - 1.0) * step[row, unit] <= length[unit] * (1.0 + LATE):
                best = min(best, value[row, unit])
    if not np.isfinite(best):
        return 0
    weights, place, front, count = 0.0, complex(0.0), complex(0.0), 0
    for row in range(ring):
        if frames[row, 0] < fewest:
            continue
        seen = frames[row, 0] - 1.0
        begin = at - int(seen)
        n = points * (seen + 1.0)
        middle = input_sum[row] / n
        for unit in range(start.shape[0]):
            worse = value[row, unit] - best
            if not worse < FAR * spread or seen * step[row, unit] > length[unit] * (1.0 + LATE):
                continue
            own = sums[row, unit, 1] / n
            turn = turn_of(sums[row, unit, 0] - n * own.conjugate() * middle)
            here, front_here = _root_at(
                root, facing, record_first[unit], record_stop[unit], start[unit] + seen * step[row, unit]
            )
            weight = np.exp(-worse / spread)
            weights += weight
            place += weight * (turn * (here - own) + middle + x[begin % ring, 0])
            front += weight * turn * front_here
            count += 1
    found[0], found[1] = place / weights, front / weights
    return count
