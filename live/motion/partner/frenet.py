"""Frenet frames: a path that is drawn in its time, as the shadow of somebody's hips who walks along it (H019)."""

from typing import Final

import numpy as np
import numpy.typing as npt
from scipy.ndimage import gaussian_filter1d

from live.motion.partner.cloud import Cloud, shadows

Float64 = npt.NDArray[np.float64]

STILL: Final = 0.1
"""Slower than this [m/s] a path says nothing of where somebody faces: the heading is held."""


def frenet_cloud(time: Float64, place: Float64, rate: float, *, smooth: float = 0.0) -> Cloud:
    """The control of a path: `place` (n, 2), x and z [m], at `time` (n,) [s], ascending; `rate` [Hz] of the cloud.

    `smooth` [s] is the width of a Gaussian over time and place; paths of mice and phones come in jerks. Facing is
    along the path; where it rests, as it was before (at the beginning as it will be).
    """
    count = max(int((time[-1] - time[0]) * rate + 1e-6) + 1, 2)
    at = time[0] + np.arange(count) / rate
    middle = np.interp(at, time, place[:, 1]) + 1j * np.interp(at, time, place[:, 0])
    if smooth > 0.0:
        width = smooth * rate
        middle = gaussian_filter1d(middle.real, width, mode="nearest") + 1j * gaussian_filter1d(
            middle.imag, width, mode="nearest"
        )
    velocity = np.gradient(middle) * rate
    speed = np.abs(velocity)
    moves = speed > STILL
    facing = np.ones(count, np.complex128)
    if moves.any():
        latest = np.maximum.accumulate(np.where(moves, np.arange(count), -1))
        latest = np.where(latest < 0, int(np.argmax(moves)), latest)
        facing = velocity[latest] / speed[latest]
    return shadows(middle, 1j * facing, rate)
