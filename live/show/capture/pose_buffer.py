"""HeardPoses: the last captured poses of one performer, as they came, in arrays that kernels sample.

Anchor: how far the place that a suit says of its wearer lies from the one that a tracker says, slowly followed.

A suit knows the body well and the place badly: it adds up steps, and drifts by metres in an hour. A tracker knows the
place, but trembles. What changes slowly between the two is the suit's error: that alone is corrected, so that feet
slide no more than the drift makes them.
"""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.ticks import TICK
from live.motion.capture.capture_kernels import BEAT, TIME
from live.motion.skeleton import JOINT_COUNT, MIRROR

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

MEMORY: Final = 32
"""Poses that are remembered ..."""
CANON_MEMORY: Final = 1024
"""... and with a canon, those of some measures."""
GAP: Final = 0.1
"""After a silence of more than this [s] the pose that was held becomes the new one ..."""
CATCH: Final = 0.2
"""... within so many seconds ..."""
TURN_OVER: Final = 0.6
"""... and so long it takes her to become her mirror image [s]."""
OTHER: Final[Int32] = np.array(MIRROR, np.int32)
"""The joint of the other side, (J,)."""


class HeardPoses:
    """Poses of one performer, and the one that was held before the last gap. Thread: the show's."""

    def __init__(self) -> None:
        self.count = 0
        """Poses that have come."""
        self._gap, self._catch = -math.inf, CATCH
        self._root: Float32 = np.zeros((MEMORY + 1, 3), np.float32)
        self._turned: Float32 = np.zeros((MEMORY + 1, JOINT_COUNT, 4), np.float32)
        self.stamp: Float64 = np.full((MEMORY, 2), -np.inf)
        """When each came [s], and the danced beat then, (M, 2)."""

    @property
    def kept(self) -> tuple[Float32, Float32, Float64, int]:
        """Hips (M + 1, 3) [m], local rotations (M + 1, J, 4), when they came (M, 2), how many: as kernels take them."""
        return self._root, self._turned, self.stamp, self.count

    @property
    def _newest(self) -> int:
        return (self.count - 1) % len(self.stamp)

    @property
    def last(self) -> float:
        """When the newest came [s]."""
        return float(self.stamp[self._newest, TIME]) if self.count else -math.inf

    @property
    def beats(self) -> tuple[float, float]:
        """The danced beats of the oldest and the newest that are remembered; there must be one."""
        oldest = max(self.count - len(self.stamp), 0) % len(self.stamp)
        return float(self.stamp[oldest, BEAT]), float(self.stamp[self._newest, BEAT])

    def hear(self, root: Float32, turned: Float32, time: float, beat: float) -> None:
        """A pose that is newer than `last`, at `time` [s] and the danced `beat`; of several within a tick the newest
        stays."""
        newest = self._newest
        if self.count and time - self.last > GAP:
            self._gap, self._catch = time, CATCH
            self._root[-1], self._turned[-1] = self._root[newest], self._turned[newest]
        if not self.count or time // TICK > self.last // TICK:
            self.count += 1
            newest = self._newest
        self._root[newest], self._turned[newest], self.stamp[newest] = root, turned, (time, beat)

    def shift(self, way: tuple[float, float]) -> None:
        """All that is remembered was elsewhere by so much [m]."""
        self._root[:, ::2] += way

    def turn_over(self, time: float) -> None:
        """From `time` [s] on they are seen as in a mirror, or not any more: softly, from what was seen then."""
        # what was seen is kept as the pose held before a gap, told so that the new way of seeing shows it as it was
        shown = np.flatnonzero(self.stamp[:, TIME] <= time)
        then = shown[np.argmax(self.stamp[shown, TIME])] if len(shown) else self._newest
        self._root[-1] = self._root[then] * (-1.0, 1.0, 1.0)
        self._turned[-1] = self._turned[then][OTHER] * (1.0, 1.0, -1.0, -1.0)
        self._gap, self._catch = time, TURN_OVER

    def caught(self, when: float) -> float:
        """How far the pose of `when` [s] has come back after the last gap."""
        part = min(max((when - self._gap) / self._catch, 0.0), 1.0)
        return part * part * (3.0 - 2.0 * part)

    def remember(self, much: bool) -> None:
        """Remember as many poses as a canon needs, or few."""
        size = CANON_MEMORY if much else MEMORY
        if size == len(self.stamp):
            return
        kept = min(self.count, size, len(self.stamp))
        order = np.arange(self.count - kept, self.count)
        before = len(self.stamp)
        stamp = np.full((size, 2), -np.inf)
        stamp[order % size] = self.stamp[order % before]
        for name in ("_root", "_turned"):
            old = getattr(self, name)
            fresh = np.zeros((size + 1, *old.shape[1:]), np.float32)
            fresh[order % size], fresh[-1] = old[order % before], old[-1]
            setattr(self, name, fresh)
        self.stamp = stamp


LAG: Final = 1.0
"""So much later [s] the correction follows what a suit drifts: two low-passes of half of it each, one after the other.
One alone would pass the tracker's noise on into the speed of her feet; two make 9 mm/s of noise of 5 cm at 60 Hz, not
50, with the same lag behind a steady drift (its speed times this)."""
WALK: Final = 1.2
"""The correction is no faster than somebody who walks [m/s]: a tracker that comes back, or is mistaken for a moment,
makes nobody jump ..."""
FAR: Final = 3.0
"""... but from farther off than this [m], which would take her more than 2.5 s in a place where she is not: there the
bound grows with the square of the distance, and what remains is how fast the low-passes are, 0.74 of it in a second."""
_SHARE: Final = 1.0 - math.exp(-2.0 * TICK / LAG)

Place = tuple[float, float]


class Anchor:
    """The correction of one performer, in her own floor's metres. Thread: the show's."""

    def __init__(self) -> None:
        self.offset: Place = (0.0, 0.0)
        """What is added to the suit's place now [m]."""
        self.apart: Place = (0.0, 0.0)
        """How far the tracker was from the suit when both were heard of last [m]."""
        self._mean: Place = (0.0, 0.0)

    def compare(self, tracker: Place, suit: Place) -> None:
        """The tracker is there while the suit says that she is here [m]."""
        self.apart = tracker[0] - suit[0], tracker[1] - suit[1]

    def follow(self) -> None:
        """A tick: the correction goes after what is apart."""
        self._mean = _towards(self._mean, self.apart)
        x, z = self.offset
        to_x, to_z = _towards(self.offset, self._mean)
        left = math.hypot(self.apart[0] - x, self.apart[1] - z)
        most = WALK * TICK * max(1.0, (left / FAR) ** 2)
        slower = min(1.0, most / max(math.hypot(to_x - x, to_z - z), 1e-12))
        self.offset = x + slower * (to_x - x), z + slower * (to_z - z)

    def leap(self) -> Place:
        """Be wholly where the tracker is: for somebody of whom nothing is seen. Returns the way there [m]."""
        (x, z), self.offset, self._mean = self.offset, self.apart, self.apart
        return self.offset[0] - x, self.offset[1] - z

    def let_go(self) -> None:
        """No tracker counts any more: the correction goes away again."""
        self.apart = 0.0, 0.0

    @property
    def numbers(self) -> tuple[float, ...]:
        """Its whole state."""
        return *self.offset, *self.apart, *self._mean


def _towards(here: Place, there: Place) -> Place:
    return here[0] + _SHARE * (there[0] - here[0]), here[1] + _SHARE * (there[1] - here[1])
