"""Kernel of the constellation: the strokes between a dancer's joints, and to those of neighbours."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel

STROKE_NUMBERS = 9
"""Numbers of a stroke: from x, y, z to x, y, z [m], dancer, brightness, radius [m]; a point begins where it ends."""

Float32 = npt.NDArray[np.float32]
Bool = npt.NDArray[np.bool_]
Int32 = npt.NDArray[np.int32]


@inline_kernel
def _apart(one: Float32, other: Float32) -> float:
    """Return the distance of two places."""
    return math.sqrt((one[0] - other[0]) ** 2 + (one[1] - other[1]) ** 2 + (one[2] - other[2]) ** 2)


@inline_kernel
def _stroke(out: Float32, count: int, begin: Float32, end: Float32, dancer: int, bright: float, radius: float) -> int:
    """Add a stroke if there is room; return the number of strokes."""
    if count >= out.shape[0]:
        return count
    for axis in range(3):
        out[count, axis] = begin[axis]
        out[count, 3 + axis] = end[axis]
    out[count, 6] = dancer
    out[count, 7] = bright
    out[count, 8] = radius
    return count + 1


@kernel("i8(f4[:,:,::1], b1[::1], i4[::1], i4[::1], f4[::1], f8, f8, f4[:,::1])")
def fill_strokes(
    position: Float32,
    present: Bool,
    parents: Int32,
    tips: Int32,
    weight: Float32,
    reach: float,
    bright: float,
    out: Float32,
) -> int:
    """Fill `out` (S, STROKE_NUMBERS) with strokes as long as there is room; return their number.

    position (A, J, 3) [m], present (A,), parents (J,) with -1 for the root, weight (J,): brightness of each joint's
    point. Each dancer has a point for each joint and a line to its parent; two dancers are joined from tip to tip,
    tips (T,), if these are nearer than `reach` [m], the brighter the nearer: so no line appears at once.
    """
    count = 0
    for a in range(position.shape[0]):
        if not present[a]:
            continue
        for j in range(position.shape[1]):
            place = position[a, j]
            count = _stroke(out, count, place, place, a, bright * weight[j], 0.010 + 0.014 * weight[j])
            if parents[j] >= 0:
                count = _stroke(out, count, place, position[a, parents[j]], a, bright * 0.34, 0.0045)
    for a in range(position.shape[0]):
        for b in range(a + 1 if present[a] else position.shape[0], position.shape[0]):
            if present[b] and _apart(position[a, 0], position[b, 0]) < reach + 1.9:  # an arm and a leg reach no farther
                for tip in tips:
                    near = 1.0 - _apart(position[a, tip], position[b, tip]) / reach
                    if near > 0.0:
                        seen = bright * 0.30 * near * near * (3.0 - 2.0 * near)
                        count = _stroke(out, count, position[a, tip], position[b, tip], a, seen, 0.0032)
    return count
