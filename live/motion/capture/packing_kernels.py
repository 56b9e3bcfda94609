"""Rotations of a packed pose, out of its bytes."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
UInt8 = npt.NDArray[np.uint8]

STEPS = 16383
"""Steps of a component to one side of zero: 15 bits."""


@kernel("void(f4[:,::1], u1[::1])")
def read_rotations(rotation: Float32, data: UInt8) -> None:
    """Write `rotation` (J, 4) as six bytes of `data` for each joint say: see `live.motion.packed_pose`."""
    scale = 1.0 / (math.sqrt(2.0) * STEPS)
    kept = np.empty(3)
    for j in range(rotation.shape[0]):
        bits = 0
        for k in range(6):
            bits = bits * 256 + data[6 * j + k]
        out, squares = (bits >> 45) & 3, 0.0
        for k in range(3):
            kept[k] = (((bits >> (30 - 15 * k)) & 0x7FFF) - STEPS) * scale
            squares += kept[k] * kept[k]
        # hostile letters may hold components that no rotation has together
        last, size = math.sqrt(max(1.0 - squares, 0.0)), math.sqrt(max(squares, 1.0))
        n = 0
        for c in range(4):
            if c == out:
                rotation[j, c] = last / size
            else:
                rotation[j, c] = kept[n] / size
                n += 1
