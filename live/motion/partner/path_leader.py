"""Leader cloud of a timed drawn path, from its Frenet frames, and correction of the walk towards the path (H019).

Units are whole strides. Where a path pauses or ends within a stride, the walk would overshoot by the rest of it, so
the result is kept near the path in place and time.
"""

from dataclasses import replace
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.motion.clip import Clip
from live.motion.partner.point_clouds import Cloud, hip_projections

MIN_SPEED: Final = 0.1
"""Below this speed [m/s] a path does not define the facing, and the heading is held."""


def frenet_cloud(time: Float64, place: Float64, rate: float, *, smooth: float = 0.0) -> Cloud:
    """Return the control cloud of a path: `place` (n, 2), x and z [m], at `time` (n,) [s], ascending.

    `rate` [Hz] is that of the cloud. `smooth` [s] is the standard deviation of a Gaussian filter, because paths from
    mice and phones are jerky. Facing is along the path. Where the path rests, the last heading is held (at the
    beginning the first one).
    """
    from scipy.ndimage import gaussian_filter1d

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
    moves = speed > MIN_SPEED
    facing = np.ones(count, np.complex128)
    if moves.any():
        latest = np.maximum.accumulate(np.where(moves, np.arange(count), -1))
        latest = np.where(latest < 0, int(np.argmax(moves)), latest)
        facing = velocity[latest] / speed[latest]
    return hip_projections(middle, 1j * facing, rate)


MAX_DISTANCE: Final = 0.12
"""Largest distance of the hips from the path [m]."""
SMOOTHING_S: Final = 0.12
"""Standard deviation of the smoothing of the correction [s]."""


def keep_near_path(clip: Clip, path: Cloud, max_distance: float = MAX_DISTANCE) -> Clip:
    """Return the clip, hips at most about `max_distance` [m] from the middle of `path`'s points; needs equal rates."""
    from scipy.ndimage import gaussian_filter1d, maximum_filter1d

    count = min(clip.sample_count, path.count)
    middle = path.floor.mean(axis=1)
    middle = np.concatenate((middle[:count], np.full(clip.sample_count - count, middle[count - 1])))
    away = clip.root_position[:, 2].astype(np.float64) + 1j * clip.root_position[:, 0] - middle
    size = np.abs(away)
    share = np.maximum(1.0 - max_distance / np.maximum(size, max_distance), 0.0)
    if not share.any():
        return clip
    width = SMOOTHING_S * clip.sample_rate
    share = gaussian_filter1d(maximum_filter1d(share, 2 * round(2.0 * width) + 1), width, mode="nearest")
    root = clip.root_position.copy()
    root[:, 0] -= (share * away.imag).astype(np.float32)
    root[:, 2] -= (share * away.real).astype(np.float32)
    return replace(clip, root_position=root)
