"""VmcStream: one sender's bones, put together to whole poses and stamped with the time at which they were taken."""

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from live.clock.ticks import TICK
from live.control.capture.mocap_seats import Seat
from live.control.capture.vmc_decode import Bone, read_packet
from live.control.events.capture import MocapFrame
from live.control.registry.rejections import Reason, Tally
from live.motion.capture.captured_body import CapturedBody
from live.motion.skeleton import JOINT_COUNT

LATE: Final = 0.25
"""A pose that seems to have been on the way for longer [s] is stamped with its arrival: the sender's clock leapt."""
DRIFT: Final = 5e-4
"""Clocks of two machines differ by no more than this share."""
THIN: Final = 0.75 * TICK
"""Poses that come sooner after another [s] are left out: the show takes one a tick."""
FOREVER: Final = 1e6
FULL: Final = (1 << JOINT_COUNT) - 1
"""All bones of the skeleton, a bit for each."""


class VmcStream:
    """What one sender sends, of one performer. Thread: one.

    A pose is whole when as many bones have come as usual. One that is not when its first bone, the hips, comes again
    has lost a packet and is left out; unless the same bones were missing in the one before, for then there are no more.
    """

    def __init__(self, seat: Callable[[float], Seat | None], tally: Tally, give: Callable[[MocapFrame], None]) -> None:
        """`seat` says, at a time [s], which performer this is; `give` gets every pose."""
        self.performer = ""
        """Who it is; empty before the first pose."""
        self.poses = 0
        """Whole poses so far."""
        self.is_tracked = True
        self.last = -math.inf
        """When the last pose was given [s]."""
        self._seat, self._tally, self._give = seat, tally, give
        self._body = CapturedBody()
        self._bones, self._known = np.zeros((JOINT_COUNT, 7)), np.zeros(JOINT_COUNT, np.bool_)
        self._bones[:, 3] = 1.0
        self._root = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        self._got, self._usual, self._left_out = 0, FULL, 0
        self._now = 0.0
        self._sent: float | None = None
        self._least, self._since = math.inf, 0.0

    @property
    def bones(self) -> int:
        """Bones of the engine's skeleton that have come."""
        return int(self._known.sum())

    def hear(self, data: bytes, now: float) -> None:
        """Take up a packet that came at `now` [s]."""
        self._now = now
        read_packet(data, self, self._tally)
        if self._got & self._usual == self._usual:
            self._close()

    # -- what a packet says ------------------------------------------------------------------------------------------

    def bone(self, joint: int, bone: Bone) -> None:
        """See `vmc_decode.Listener`."""
        bit = 1 << joint
        if self._got & bit or (joint == 0 and self._got):
            self._leave_out()
        self._bones[joint], self._known[joint] = bone, True
        self._got |= bit

    def root(self, bone: Bone) -> None:
        """See `vmc_decode.Listener`."""
        self._root[:] = bone

    def tracked(self, on: bool) -> None:
        """See `vmc_decode.Listener`."""
        self.is_tracked = on

    def sent(self, time: float) -> None:
        """See `vmc_decode.Listener`."""
        if abs(time) < FOREVER:
            self._sent = time

    def _leave_out(self) -> None:
        """Bones of the next pose come before this one was whole."""
        if not self._got & 1:
            self._usual |= self._got  # after a loss poses were thought to have fewer bones than they have
        elif self._got == self._left_out:
            self._usual = self._got
            self._close()
            return
        self._tally.count(Reason.TRUNCATED)
        self._left_out, self._got = self._got, 0

    # -- whole poses ---------------------------------------------------------------------------------------------------

    def _close(self) -> None:
        """A pose is whole: it goes to the show, if it is meant."""
        self._got = self._left_out = 0
        time, self._sent = self._stamp(), None
        if not self.is_tracked or time - self.last < THIN:
            return
        seat = self._seat(self._now)
        if seat is None:
            self._tally.count(Reason.SENDER)
            return
        self.performer = seat.name
        try:
            pose = self._body.packed(self._bones, self._known, self._root, time, find_floor=seat.floor)
        except ValueError:
            self._tally.count(Reason.OUT_OF_RANGE)
            return
        self.poses += 1
        self.last = time
        self._give(MocapFrame(time=time, source="vmc", performer=seat.name, pose=pose))

    def _stamp(self) -> float:
        """When the pose was taken [s], by the sender's clock if it says: networks deliver in fits and starts.

        The packet that was on the way for the shortest time says how far apart the clocks are.
        """
        now = self._now
        if self._sent is None:
            return now
        apart = now - self._sent
        self._least = min(self._least + DRIFT * (now - self._since), apart)
        self._since = now
        if apart - self._least > LATE:
            self._least = apart
        return self._sent + self._least

    def facts(self, now: float) -> dict[str, Any]:
        """For the status."""
        ago = now - self.last
        return {
            "poses": self.poses, "bones": self.bones, "tracked": self.is_tracked,
            "last_s_ago": round(ago, 2) if math.isfinite(ago) else None,
        }  # fmt: skip
