"""Frenet frames: a path that is drawn in its time, as the shadow of somebody's hips who walks along it (H019).

Leash: who walks along a path stays near it in place and time, so that she ends where it ends (H019).

Units are laid on the path as whole strides; where it rests, or ends, within one, she would go on by the rest of it.
"""

from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from live.motion.clip import Clip
from live.motion.partner.point_clouds import Cloud, shadows

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


NEAR: Final = 0.12
"""So far [m] she may be from where the path is."""
EASES: Final = 0.12
"""Standard deviation [s] of how what is mended comes and goes."""


def leashed(clip: Clip, path: Cloud, near: float = NEAR) -> Clip:
    """The clip with its hips no farther than about `near` [m] from the middle of `path`'s points, at the same rate."""
    count = min(clip.sample_count, path.count)
    middle = path.floor.mean(axis=1)
    middle = np.concatenate((middle[:count], np.full(clip.sample_count - count, middle[count - 1])))
    away = clip.root_position[:, 2].astype(np.float64) + 1j * clip.root_position[:, 0] - middle
    size = np.abs(away)
    share = np.maximum(1.0 - near / np.maximum(size, near), 0.0)
    if not share.any():
        return clip
    width = EASES * clip.sample_rate
    share = gaussian_filter1d(maximum_filter1d(share, 2 * round(2.0 * width) + 1), width, mode="nearest")
    root = clip.root_position.copy()
    root[:, 0] -= (share * away.imag).astype(np.float32)
    root[:, 2] -= (share * away.real).astype(np.float32)
    return replace(clip, root_position=root)
