"""Units that run in a frame, scored by their beginnings.

Times are frames; rings of R frames, row t % R.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel, part
from live.motion.partner_live.finishing_kernels import best_way, turn_of

Float64 = npt.NDArray[np.float64]
Complex128 = npt.NDArray[np.complex128]
Int64 = npt.NDArray[np.int64]

SURE: Any = 5.0
"""Before so many frames are seen no boundary is given up."""


@part
def _sample(floor: Complex128, height: Float64, first: int, stop: int, place: float, p: int) -> Any:
    """Point p of a recording, whose samples are `first` to `stop` - 1, at the sample `place` of it."""
    place = min(max(place, 0.0), float(stop - first - 1))
    low = min(int(place), max(stop - first - 2, 0))
    w = place - low
    one, other = first + low, min(first + low + 1, stop - 1)
    return (1.0 - w) * floor[one, p] + w * floor[other, p], (1.0 - w) * height[one, p] + w * height[other, p]


@kernel(
    "void(i8,f8,c16[:,::1],f8[:,::1],c16[:,::1],f8[:,::1],i8[::1],i8[::1],f8[::1],f8[:,::1],c16[:,::1],f8[:,::1],"
    "f8[:,::1],f8[:,:,::1],c16[:,:,::1],f8[:,:,::1],c16[::1],f8[:,::1],f8[:,::1],f8[:,::1],f8)"
)
def score_running(
    at: int,
    k: float,
    x: Complex128,
    x_height: Float64,
    control: Complex128,
    control_height: Float64,
    record_first: Int64,
    record_stop: Int64,
    start: Float64,
    step: Float64,
    head: Complex128,
    head_height: Float64,
    score: Float64,
    end: Float64,
    sums: Complex128,
    squares: Float64,
    input_sum: Complex128,
    input_square: Float64,
    frames: Float64,
    value: Float64,
    beam: float,
) -> None:
    """All units that run at frame `at`, by what is seen of them: value (R, N), for each boundary and unit its score.

    control (S, P): the samples of all recordings; of unit n they are record_first[n] to record_stop[n] - 1, and it
    begins at the sample start[n] of those; step (R, N): samples a frame, as the clock has it, 0 where a unit does not
    run. head (N, 4): the unit's first target sample. sums (R, N, 2): running conj(a) · x and sum of a; squares (R, N,
    2): running |a|² and squared differences of heights; input_sum (R,) and input_square (R, 1), frames (R, 1): of the
    input since each boundary. A boundary whose units are all worse than the best one of all by more than `beam` [m²]
    is given up: its frames become -1.
    """
    ring, points = x.shape
    best_of_all = np.inf
    for row in range(ring):
        if not np.isfinite(score[row, 0]) or frames[row, 0] < 0.0:
            continue
        seen = int(frames[row, 0])
        begin = at - seen
        origin = x[begin % ring, 0]
        for p in range(points):
            z = x[at % ring, p] - origin
            input_sum[row] += z
            input_square[row, 0] += z.real * z.real + z.imag * z.imag
        n = points * (seen + 1)
        middle = input_sum[row] / n
        for unit in range(start.shape[0]):
            if step[row, unit] <= 0.0:
                value[row, unit] = np.inf
                continue
            place = start[unit] + seen * step[row, unit]
            for p in range(points):
                a, y = _sample(control, control_height, record_first[unit], record_stop[unit], place, p)
                z = x[at % ring, p] - origin
                sums[row, unit, 0] += a.conjugate() * z
                sums[row, unit, 1] += a
                squares[row, unit, 0] += a.real * a.real + a.imag * a.imag
                rise = x_height[at % ring, p] - y
                squares[row, unit, 1] += rise * rise
            own = sums[row, unit, 1] / n
            product = sums[row, unit, 0] - n * own.conjugate() * middle
            left = input_square[row, 0] - n * (middle.real * middle.real + middle.imag * middle.imag)
            left += squares[row, unit, 0] - n * (own.real * own.real + own.imag * own.imag)
            turn = turn_of(product)
            shift = middle + origin - turn * own
            best, way = best_way(score[row], end[row], k, turn, shift, head[unit], head_height[unit])
            value[row, unit] = best + left - 2.0 * np.abs(product) + squares[row, unit, 1]
            if way < 0:
                value[row, unit] = np.inf
            best_of_all = min(best_of_all, value[row, unit])
        frames[row, 0] += 1.0
    for row in range(ring):
        if frames[row, 0] > SURE and value[row].min() > best_of_all + beam:
            frames[row, 0] = -1.0
