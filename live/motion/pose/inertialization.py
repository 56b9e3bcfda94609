"""Inertialization state: differences that remain after each dancer's last cut."""

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float32, Float64, Int32
from live.motion.pose.inertialization_kernels import COLUMNS, DURATION, MAX_FADE_TIME, record_difference, update_ages


def zero_differences(count: int, joints: int) -> Float32:
    """Return zero differences for `count` dancers of `joints` joints, (count, joints + 1, 7)."""
    settling = np.zeros((count, joints + 1, COLUMNS), np.float32)
    settling[:, :, DURATION] = MAX_FADE_TIME
    return settling


class Inertialization:
    """Fading differences of A dancers of J joints after their cuts; passed to the pose pipelines."""

    def __init__(self, dancer_count: int, joint_count: int) -> None:
        self.difference: Float32 = zero_differences(dancer_count, joint_count)
        """Offset, speed and duration per joint and for the hips, columns as in `inertialization_kernels`, shape (A, J +
        1, 7)."""
        self.cut_time: Float64 = np.full(dancer_count, -np.inf)
        """Time of each dancer's last cut [s], shape (A,)."""
        self.age: Float32 = np.full(dancer_count, MAX_FADE_TIME, np.float32)
        """Time since that cut [s], at most MAX_FADE_TIME, shape (A,); updated by `update_age`."""
        self.any_fading = False
        """Whether any difference was still fading at the last `update_age`."""

    def update_age(self, time: float) -> None:
        """Update `age` to `time` [s]."""
        self.any_fading = update_ages(self.age, self.cut_time, time)

    @property
    def fading(self) -> Bool:
        """Dancers whose differences are still fading, shape (A,)."""
        return np.asarray(self.age < MAX_FADE_TIME)

    def cut(
        self,
        rows: Int32,
        before: tuple[Float32, Float32],
        after: tuple[Float32, Float32],
        parents: Int32,
        *,
        time: float,
        dt: float,
    ) -> None:
        """Record a cut of the dancers `rows` (n,) at `time` [s].

        `before` and `after`: world positions (2, n, J, 3) [m] and rotations (2, n, J, 4) of the old and the new motion,
        at the cut and `dt` [s] earlier (later if it is negative).
        """
        record_difference(self.difference, rows, before[1], before[0], after[1], after[0], parents, dt)
        self.cut_time[rows] = time

    def clear(self, rows: npt.NDArray[np.integer]) -> None:
        """Drop the differences of the dancers `rows` (n,)."""
        self.cut_time[rows] = -np.inf
        self.age[rows] = MAX_FADE_TIME
