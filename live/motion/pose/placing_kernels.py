"""Where held and free feet are between two ticks, for the pose kernels."""

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.motion.pose.legs_kernels import (
    FOLLOWED_COLUMNS,
    HELD,
    LIFT,
    SHIFT_X,
    SHIFT_Z,
    SLID,
    SPEED_X,
    SPEED_Y,
    SPEED_Z,
    STOOD,
)

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]


@kernel("void(f4[:,:,::1], f4[:,:,::1], f4)")
def swing_feet(feet: Float32, lock: Float32, age: float) -> None:
    """Write `feet` (A, 2, 9) from the foot lock `lock` (A, 2, 12), `age` [s] after its tick: free feet swing on."""
    for n in range(lock.shape[0]):
        for side in range(2):
            row, out = lock[n, side], feet[n, side]
            for c in range(FOLLOWED_COLUMNS):
                out[c] = row[c]
            free = age * (np.float32(1.0) - row[HELD])
            out[SHIFT_X] += free * row[SPEED_X]
            out[SHIFT_Z] += free * row[SPEED_Z]
            out[LIFT] += free * row[SPEED_Y]


@kernel("f4(f4[:,:,::1])")
def farthest_shift(lock: Float32) -> float:
    """How far [m] any foot of the foot lock `lock` (A, 2, 12) is shifted along x or z."""
    most: float = np.float32(0.0)  # type: ignore[assignment]
    for n in range(lock.shape[0]):
        for side in range(2):
            most = max(most, max(abs(lock[n, side, SHIFT_X]), abs(lock[n, side, SHIFT_Z])))
    return most


@kernel("void(f4[:,:,::1], f8[::1], f8[::1])")
def take_slid(lock: Float32, slid: Float64, stood: Float64) -> None:
    """Take out of the foot lock how far both feet have `slid` (A,) [m] and for how long they `stood` (A,) [s]."""
    for n in range(lock.shape[0]):
        slid[n] = float(lock[n, 0, SLID]) + float(lock[n, 1, SLID])
        stood[n] = float(lock[n, 0, STOOD]) + float(lock[n, 1, STOOD])
        for side in range(2):
            lock[n, side, SLID] = lock[n, side, STOOD] = np.float32(0.0)


@kernel("void(b1[:,::1], f8[::1])")
def hold_where_wanted(contact: Bool, wanted: Float64) -> None:
    """Feet of those whose `wanted` (A,) is 0 are never held: their `contact` (A, 2) does not count."""
    for n in range(contact.shape[0]):
        if wanted[n] == 0.0:
            contact[n, 0] = contact[n, 1] = False
