"""The last poses of a seen performer with their beats, and takes: what of them is to be learnt."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float32, Float64
from live.motion.capture.packed_pose import unpack_pose
from live.motion.skeleton import JOINT_COUNT

CAPACITY: Final = 1024
"""Poses that are kept: 16 s of a suit at 64 a second, half a minute of a camera at 30."""
LEAD_OUT_BEATS: Final = 0.5
"""Beats of a take that are kept after its end."""
JUMP_BACK: Final = 1.0
"""If the beats go back by more than this, because the clock was set, older poses are forgotten."""


class DancedPoses:
    """Poses of one performer in the order of their beats, in rings of CAPACITY rows. Thread: the show's."""

    def __init__(self) -> None:
        self.count = 0
        """Number of poses kept or overwritten."""
        self._hips: Float32 = np.zeros((CAPACITY, 3), np.float32)
        self._rotation: Float32 = np.zeros((CAPACITY, JOINT_COUNT, 4), np.float32)
        self._stamp: Float64 = np.zeros((CAPACITY, 2))
        """Beat and time [s] of each pose, (CAPACITY, 2)."""

    def add(self, pose: str, beat: float, time: float) -> None:
        """Keep a packed pose at the danced `beat` and `time` [s], unless it is late; ValueError for an invalid one."""
        hips, rotation = unpack_pose(pose)
        if self.count:
            ahead = beat - self.last_beat
            if -JUMP_BACK <= ahead <= 0.0:
                return
            if ahead < -JUMP_BACK:
                self.count = 0
        row = self.count % CAPACITY
        self._hips[row], self._rotation[row], self._stamp[row] = hips, rotation, (beat, time)
        self.count += 1

    @property
    def last_beat(self) -> float:
        """Beat of the newest pose; there must be one."""
        return float(self._stamp[(self.count - 1) % CAPACITY, 0])

    @property
    def first_beat(self) -> float:
        """Beat of the oldest pose that is kept; there must be one."""
        return float(self._stamp[max(self.count - CAPACITY, 0) % CAPACITY, 0])

    def between(self, first: float, last: float) -> tuple[Float32, Float32, Float64]:
        """Return the poses from beat `first` to `last`: hips (T, 3) [m], local rotations (T, J, 4), and beats and
        times [s] (T, 2)."""
        order = np.arange(max(self.count - CAPACITY, 0), self.count) % CAPACITY
        beats = self._stamp[order, 0]
        begin, end = np.searchsorted(beats, first), np.searchsorted(beats, last, side="right")
        rows = order[begin:end]
        return self._hips[rows], self._rotation[rows], self._stamp[rows]

    @property
    def is_whole(self) -> bool:
        """Whether the arrays fit each other."""
        return (
            self._hips.shape == (CAPACITY, 3)
            and self._rotation.shape == (CAPACITY, JOINT_COUNT, 4)
            and self._stamp.shape == (CAPACITY, 2)
            and self.count >= 0
        )


@dataclass(slots=True, eq=False)
class Take:
    """What a performer danced and the show is to learn: some measures, with what came before and after them."""

    performer: str
    name: str
    """Name of the step it becomes."""
    group: str
    """Words for the dancers who dance it."""
    repeats: int
    """How often they dance it."""
    measures: int
    beats_per_measure: int
    first: float
    """Danced beat at which it begins."""
    hips: Float32
    """(T, 3) [m]; empty before it is over."""
    rotation: Float32
    """(T, J, 4)"""
    stamp: Float64
    """Beat and time [s] of each pose, (T, 2)."""

    @property
    def end(self) -> float:
        """Danced beat at which it ends."""
        return self.first + self.measures * self.beats_per_measure

    @property
    def is_over(self) -> bool:
        """Whether it was danced, so that it can be learnt."""
        return len(self.stamp) > 0

    @property
    def is_whole(self) -> bool:
        """Whether the arrays fit each other."""
        count = len(self.stamp)
        shapes = self.hips.shape == (count, 3) and self.rotation.shape == (count, JOINT_COUNT, 4)
        return shapes and self.stamp.shape == (count, 2) and self.measures > 0 and self.beats_per_measure > 0


def empty_take(
    performer: str, name: str, group: str, repeats: int, measures: int, beats_per_measure: int, first: float
) -> Take:
    """Return a take that is still to be danced, or cut out of the poses that are kept."""
    return Take(
        performer, name, group, repeats, measures, beats_per_measure, first,
        np.zeros((0, 3), np.float32), np.zeros((0, JOINT_COUNT, 4), np.float32), np.zeros((0, 2)),
    )  # fmt: skip
