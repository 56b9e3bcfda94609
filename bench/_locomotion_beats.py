"""When the drawn body strikes the pose that its clip has on a beat, against when the Timeline has that beat.

Found in the picture alone: the upper body's joints, each in its parent's axes, are compared with the clip's at the
annotated beat, picture after picture; the distance is least when the beat is shown, to a fraction of a frame.
"""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.stage_snapshot import StageView
from live.motion import quaternion
from live.motion.pose.pipeline_kernels import UPPER_FIRST, UPPER_LAST
from live.motion.pose.pose_pipeline import PoseSkeleton
from live.show.show import Show

Float64 = npt.NDArray[np.float64]

AROUND: Final = 0.2
"""Beats before and after a beat in which its pose is looked for."""
CLEAR: Final = 1e-3
"""The squared distance must grow by so much [rad²] from the best picture to those beside it: else the body rests."""


class DrawnBeats:
    """Feed it every picture of a show without time warps and amplitudes; `offsets` are in seconds."""

    def __init__(self, show: Show) -> None:
        self._show = show
        body = PoseSkeleton.whole().body
        self._joints = np.arange(body[UPPER_FIRST], body[UPPER_LAST])
        self._parents = PoseSkeleton.whole().parents[self._joints]
        self._key: tuple[int, int] | None = None
        self._pose, self._node = np.zeros(0), np.zeros(0, np.int32)
        self._rows: list[tuple[float, float, Float64]] = []
        self.offsets: list[Float64] = []

    def picture(self, view: StageView) -> None:
        """One picture, evenly spaced in time."""
        count = round(view.phase)
        inside = 1 <= count < view.beats_per_measure and abs(view.phase - count) < AROUND
        key = (view.measure, count) if inside else None
        if key != self._key:
            self._judge()
            self._key, self._rows = key, []
            if key is not None:
                self._node = self._show.dancers.node.copy()
                self._pose = self._clip_pose(count / view.beats_per_measure)
        if key is not None:
            world = view.joint_rotation.astype(np.float64)
            local = quaternion.mul(quaternion.inverse(world[:, self._parents]), world[:, self._joints])
            apart = 4.0 * (1.0 - np.minimum((local * self._pose).sum(axis=-1) ** 2, 1.0))
            self._rows.append((view.time, view.beat, apart.sum(axis=-1)))

    def _clip_pose(self, share: float) -> Float64:
        """The upper bodies (A, U, 4) of the clips danced when `share` of the measure has passed."""
        library = self._show.graph.library
        at = library.node_first[self._node] + share * (library.node_last[self._node] - library.node_first[self._node])
        low = np.minimum(at.astype(np.int64), len(library.clip_rotation) - 2)
        before, after = (library.clip_rotation[row][:, self._joints].astype(np.float64) for row in (low, low + 1))
        return np.asarray(quaternion.unit(before + (at - low)[:, None, None] * (after - before)))

    def _judge(self) -> None:
        if self._key is None or len(self._rows) < 5:
            return
        present = self._show.dancers.present
        times, beats = (np.array([row[n] for row in self._rows]) for n in range(2))
        apart = np.stack([row[2] for row in self._rows])
        best = np.clip(apart.argmin(axis=0), 1, len(apart) - 2)
        who = np.arange(apart.shape[1])
        low, middle, high = (apart[best + side, who] for side in (-1, 0, 1))
        curve = low - 2.0 * middle + high
        clear = (low > middle) & (high > middle) & (curve > CLEAR) & (self._node == present.node)
        clear &= ~present.take_share.any(axis=0)
        shown = times[best] + 0.5 * (low - high) / np.maximum(curve, 1e-12) * (times[1] - times[0])
        beat = np.interp(np.round(beats.mean()), beats, times)
        self.offsets.append((shown - beat)[clear])
