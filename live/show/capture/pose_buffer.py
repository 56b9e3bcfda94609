"""Ring buffer of a performer's captured poses, in arrays that kernels sample, and their `DriftCorrection`.

A motion capture suit measures the body well but its position drifts by metres in an hour. A tracker has no drift but is
noisy. The slowly changing part of their difference is the suit's error; only that is corrected, so that feet slide no
more than the drift requires.
"""

import math
from typing import Final

import numpy as np

from live.base.arrays import Float32, Float64, Int32
from live.clock.ticks import TICK
from live.motion.capture.capture_kernels import BEAT, TIME
from live.motion.skeleton import JOINT_COUNT, MIRROR

POSE_CAPACITY: Final = 32
"""Poses kept without a canon."""
CANON_CAPACITY: Final = 1024
"""Poses kept with a canon: several measures."""
GAP_S: Final = 0.1
"""Silence [s] after which the new pose is blended with the held one."""
GAP_BLEND_S: Final = 0.2
"""Blend time after a gap [s]."""
MIRROR_BLEND_S: Final = 0.6
"""Blend time into or out of the mirror image [s]."""
MIRROR_JOINT: Final[Int32] = np.array(MIRROR, np.int32)
"""Index of the mirrored joint, (J,)."""


class PoseBuffer:
    """Poses of one performer, and the pose held before the last gap. Thread: the show's."""

    def __init__(self) -> None:
        self.count = 0
        """Number of poses received."""
        self._blend_start, self._blend_s = -math.inf, GAP_BLEND_S
        self._root: Float32 = np.zeros((POSE_CAPACITY + 1, 3), np.float32)
        self._rotation: Float32 = np.zeros((POSE_CAPACITY + 1, JOINT_COUNT, 4), np.float32)
        self.stamp: Float64 = np.full((POSE_CAPACITY, 2), -np.inf)
        """Arrival time [s] and danced beat of each pose, (M, 2)."""

    @property
    def arrays(self) -> tuple[Float32, Float32, Float64, int]:
        """Hips (M + 1, 3) [m], local rotations (M + 1, J, 4), stamps (M, 2), and count, as kernels take them."""
        return self._root, self._rotation, self.stamp, self.count

    @property
    def _newest(self) -> int:
        return (self.count - 1) % len(self.stamp)

    @property
    def last(self) -> float:
        """Arrival time of the newest pose [s]."""
        return float(self.stamp[self._newest, TIME]) if self.count else -math.inf

    @property
    def newest(self) -> tuple[Float32, Float32]:
        """Hips (3,) [m] and local rotations (J, 4) of the newest pose; there must be one."""
        return self._root[self._newest], self._rotation[self._newest]

    @property
    def beats(self) -> tuple[float, float]:
        """Danced beats of the oldest and the newest kept pose; there must be one."""
        oldest = max(self.count - len(self.stamp), 0) % len(self.stamp)
        return float(self.stamp[oldest, BEAT]), float(self.stamp[self._newest, BEAT])

    def add(self, root: Float32, turned: Float32, time: float, beat: float) -> None:
        """Store a pose newer than `last`, at `time` [s] and the danced `beat`; within one tick the newest counts."""
        newest = self._newest
        if self.count and time - self.last > GAP_S:
            self._blend_start, self._blend_s = time, GAP_BLEND_S
            self._root[-1], self._rotation[-1] = self._root[newest], self._rotation[newest]
        if not self.count or time // TICK > self.last // TICK:
            self.count += 1
            newest = self._newest
        self._root[newest], self._rotation[newest], self.stamp[newest] = root, turned, (time, beat)

    def shift(self, way: tuple[float, float]) -> None:
        """Shift all kept positions by this displacement [m]."""
        self._root[:, ::2] += way

    def begin_mirror_blend(self, time: float) -> None:
        """Blend into or out of the mirror image from `time` [s] on, starting at the visible pose."""
        # the visible pose becomes the pose before a gap, mirrored so that the new mirror setting shows it unchanged
        shown = np.flatnonzero(self.stamp[:, TIME] <= time)
        then = shown[np.argmax(self.stamp[shown, TIME])] if len(shown) else self._newest
        self._root[-1] = self._root[then] * (-1.0, 1.0, 1.0)
        self._rotation[-1] = self._rotation[then][MIRROR_JOINT] * (1.0, 1.0, -1.0, -1.0)
        self._blend_start, self._blend_s = time, MIRROR_BLEND_S

    def gap_blend(self, when: float) -> float:
        """Return how far the pose at `when` [s] is blended in after the last gap, 0 to 1."""
        part = min(max((when - self._blend_start) / self._blend_s, 0.0), 1.0)
        return part * part * (3.0 - 2.0 * part)

    def resize(self, canon: bool) -> None:
        """Resize the buffer: large for a canon, or small."""
        size = CANON_CAPACITY if canon else POSE_CAPACITY
        if size == len(self.stamp):
            return
        kept = min(self.count, size, len(self.stamp))
        order = np.arange(self.count - kept, self.count)
        before = len(self.stamp)
        stamp = np.full((size, 2), -np.inf)
        stamp[order % size] = self.stamp[order % before]
        for name in ("_root", "_rotation"):
            old = getattr(self, name)
            fresh = np.zeros((size + 1, *old.shape[1:]), np.float32)
            fresh[order % size], fresh[-1] = old[order % before], old[-1]
            setattr(self, name, fresh)
        self.stamp = stamp


LAG_S: Final = 1.0
"""Lag [s] of the correction behind the suit's drift: two low-passes in series, each with half of it.

A single low-pass would pass tracker noise on into the speed of the feet: two turn 5 cm of noise at 60 Hz into 9 mm/s
instead of 50, with the same lag behind a steady drift (its speed times this).
"""
MAX_SPEED: Final = 1.2
"""Maximum speed of the correction [m/s]: a walk, so that a returning or briefly wrong tracker causes no jump."""
FAR_DISTANCE: Final = 3.0
"""Distance [m] beyond which this limit grows with its square, because a walk would take more than 2.5 s.

Then the low-passes limit the speed: 0.74 of the distance in a second.
"""
_SHARE: Final = 1.0 - math.exp(-2.0 * TICK / LAG_S)

Place = tuple[float, float]


class DriftCorrection:
    """Correction of one performer's position, in metres of the performer's floor. Thread: the show's."""

    def __init__(self) -> None:
        self.offset: Place = (0.0, 0.0)
        """Present correction added to the suit's position [m]."""
        self.difference: Place = (0.0, 0.0)
        """Latest difference between tracker and suit [m]."""
        self._mean: Place = (0.0, 0.0)

    def set_difference(self, tracker: Place, suit: Place) -> None:
        """Store the difference between tracker and suit positions [m]."""
        self.difference = tracker[0] - suit[0], tracker[1] - suit[1]

    def tick(self) -> None:
        """Advance one tick: move the correction towards the difference."""
        self._mean = _towards(self._mean, self.difference)
        x, z = self.offset
        to_x, to_z = _towards(self.offset, self._mean)
        left = math.hypot(self.difference[0] - x, self.difference[1] - z)
        most = MAX_SPEED * TICK * max(1.0, (left / FAR_DISTANCE) ** 2)
        slower = min(1.0, most / max(math.hypot(to_x - x, to_z - z), 1e-12))
        self.offset = x + slower * (to_x - x), z + slower * (to_z - z)

    def snap(self) -> Place:
        """Set the correction to the full difference, for a performer who is not visible; return the change [m]."""
        (x, z), self.offset, self._mean = self.offset, self.difference, self.difference
        return self.offset[0] - x, self.offset[1] - z

    def release(self) -> None:
        """Let the correction decay to zero, because the tracker no longer counts."""
        self.difference = 0.0, 0.0

    @property
    def state(self) -> tuple[float, ...]:
        """The complete state."""
        return *self.offset, *self.difference, *self._mean


def _towards(here: Place, there: Place) -> Place:
    return here[0] + _SHARE * (there[0] - here[0]), here[1] + _SHARE * (there[1] - here[1])
