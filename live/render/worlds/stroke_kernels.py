"""Kernel of the constellation: the strokes between a dancer's joints, and to those of neighbours."""

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

STROKE_NUMBERS = 9
"""Numbers of a stroke: from x, y, z to x, y, z [m], dancer, brightness, radius [m]; a point begins where it ends."""

Float32 = npt.NDArray[np.float32]
Bool = npt.NDArray[np.bool_]
Int32 = npt.NDArray[np.int32]


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
            for is_line in range(2):
                other = parents[j] if is_line else j
                if other < 0 or count >= out.shape[0]:
                    continue
                for axis in range(3):
                    out[count, axis] = position[a, j, axis]
                    out[count, 3 + axis] = position[a, other, axis]
                out[count, 6] = a
                out[count, 7] = bright * (0.34 if is_line else weight[j])
                out[count, 8] = 0.00325 if is_line else 0.010 + 0.014 * weight[j]
                count += 1
    for a in range(position.shape[0]):
        if not present[a]:
            continue
        for b in range(a + 1, position.shape[0]):
            if not present[b]:
                continue
            dx = position[a, 0, 0] - position[b, 0, 0]
            dz = position[a, 0, 2] - position[b, 0, 2]
            if dx * dx + dz * dz > (reach + 1.6) * (reach + 1.6):
                continue
            for tip in tips:
                gap = 0.0
                for axis in range(3):
                    step = position[a, tip, axis] - position[b, tip, axis]
                    gap += step * step
                gap = np.sqrt(gap)
                if gap >= reach or count >= out.shape[0]:
                    continue
                near = 1.0 - gap / reach
                for axis in range(3):
                    out[count, axis] = position[a, tip, axis]
                    out[count, 3 + axis] = position[b, tip, axis]
                out[count, 6] = a
                out[count, 7] = bright * 0.30 * near * near * (3.0 - 2.0 * near)
                out[count, 8] = 0.004
                count += 1
    return count
