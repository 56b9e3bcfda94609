"""Kernel that finds the single supports of many measures, and how a dancer turns on them (T048-T050)."""

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Bool = npt.NDArray[np.bool_]
Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]


@kernel("i8(f4[:,:,::1],f4[:,:,::1],b1[:,::1],f8,f8,i8,i8,f8,f8,f8,f8,i8[:,::1])")
def single_supports(  # noqa: C901
    ankle: Float32, ball: Float32, contact: Bool, sole: float, toes: float, start: int, last: int, shortest: float,
    least_lift: float, threshold: float, whole: float, out: Int64,
) -> int:  # fmt: skip
    """Write start, stop (exclusive) and foot of the supports among samples `start` to `whole` to out; see
    `turn_insertion.find_supports`.

    `ankle` and `ball` (S, 2, 3) [m] are `sole` and `toes` above the soles; samples from `last` on are not selected.
    Supports of fewer than `shortest` samples are left out, and if no foot is lifted by `least_lift` [m], all; the
    longest that out (M, 3) holds are kept, in order. Returns their number.
    """
    stop = int(whole)
    highest = 0.0
    height = np.empty(2)
    for s in range(start, stop):
        for foot in range(2):
            height[foot] = min(float(ankle[s, foot, 1]) - sole, float(ball[s, foot, 1]) - toes)
        highest = max(highest, abs(height[1] - height[0]))
    if stop <= start or highest < least_lift:
        return 0
    count = begin = state = 0
    for s in range(start, stop + 1):
        now = 0
        if s < stop and s < max(last, start) and not (contact[s, 0] and contact[s, 1]):
            for foot in range(2):
                height[foot] = min(float(ankle[s, foot, 1]) - sole, float(ball[s, foot, 1]) - toes)
            if abs(height[1] - height[0]) > threshold * highest:
                now = 1 if height[0] <= height[1] else 2
        if now == state:
            continue
        if state > 0 and s - begin >= shortest - 1e-9:
            at = count
            if count == out.shape[0]:
                at = 0
                for n in range(count):  # of equal ones the last goes
                    if out[n, 1] - out[n, 0] <= out[at, 1] - out[at, 0]:
                        at = n
                if out[at, 1] - out[at, 0] >= s - begin:
                    at = -1
                else:
                    for n in range(at, count - 1):
                        for c in range(3):
                            out[n, c] = out[n + 1, c]
                    at = count = count - 1
            if at >= 0:
                out[at, 0], out[at, 1], out[at, 2] = begin, s, state - 1
                count += 1
        begin, state = s, now
    return count


@kernel("void(f4[:,:,::1],f4[:,:,::1],b1[:,::1],f8,f8,f8[::1],f8[::1],f8[::1],f8,f8,f8,f8,f8[:,:,::1],b1[::1])")
def support_rows(
    ankle: Float32, ball: Float32, contact: Bool, sole: float, toes: float, begin: Float64, size: Float64,
    shortest: Float64, least_lift: float, threshold: float, window: float, softness: float, rows: Float64, found: Bool,
) -> None:  # fmt: skip
    """Write the turns of N measures that begin at samples `begin` (N,) and last `size` (N,) to rows (N, M, 8).

    Columns as in `SupportTurns.rows`; the other arguments as in `single_supports`. `found` (N,): whether there is any
    single support; rows of other measures are not written.
    """
    supports = np.empty((rows.shape[1], 3), np.int64)
    for n in range(begin.shape[0]):
        first = int(np.ceil(begin[n] - 1e-9))
        last = int(np.ceil(begin[n] + (1.0 - window) * size[n] - 1e-9))
        whole = np.ceil(begin[n] + size[n] - 1e-9)
        count = single_supports(
            ankle, ball, contact, sole, toes, first, last, shortest[n], least_lift, threshold, whole, supports
        )
        found[n] = count > 0
        if count == 0:
            continue
        for k in range(rows.shape[1]):
            for c in range(8):
                rows[n, k, c] = 1.0 if c < 2 else 0.0
        total = 0
        for k in range(count):
            total += supports[k, 1] - supports[k, 0]
        for k in range(count):
            start, stop, foot = supports[k, 0], supports[k, 1], supports[k, 2]
            # a sample's turn happens between the previous sample and this one
            rows[n, k, 0] = min(max((start - 0.5 - begin[n]) / size[n], 0.0), 1.0 - window)
            rows[n, k, 1] = min(max((stop - 0.5 - begin[n]) / size[n], 0.0), 1.0 - window)
            rows[n, k, 2] = (stop - start) / total
            rows[n, k, 7] = softness
            for c in range(2):  # the least-squares line through the foot's way
                points = stop - start
                if points < 3:
                    rows[n, k, 3 + c], rows[n, k, 5 + c] = ball[start, foot, 2 * c], ball[stop - 1, foot, 2 * c]
                    continue
                middle = slope = square = 0.0
                for s in range(points):
                    along = -1.0 + 2.0 * s / (points - 1)
                    middle += ball[start + s, foot, 2 * c]
                    slope += along * ball[start + s, foot, 2 * c]
                    square += along * along
                middle, slope = middle / points, slope / square
                rows[n, k, 3 + c], rows[n, k, 5 + c] = middle - slope, middle + slope
