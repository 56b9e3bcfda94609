"""VMC over UDP: what real dancers do goes into the show's inbox, whoever sends from wherever.

Seats: which performer a sender of live motion capture is: by the port she sends to, by her machine, or by turn.

VmcStream: one sender's bones, put together to whole poses and stamped with the time at which they were taken.
"""

import math
import socket
from collections.abc import Callable, Hashable
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from live.base.event_queue import Lane
from live.clock.ticks import TICK
from live.clock.time_source import Clock
from live.control.capture.udp_input import CaptureInput
from live.control.capture.vmc_protocol import MAX_PACKET_BYTES, Bone, read_packet
from live.control.events.capture import MocapFrame
from live.control.events.events import ControlEvent
from live.control.osc.osc_socket import bound_socket
from live.control.registry.rejections import Reason, Tally
from live.motion.capture.captured_body import CapturedBody
from live.motion.skeleton import JOINT_COUNT

ALONE: Final = "live"
"""The performer's name where the patch names none."""
GONE_AFTER: Final = 2.0
"""Who has sent nothing for so long [s] leaves her place to another sender."""


@dataclass(frozen=True, slots=True)
class Seat:
    """A performer of the patch, and what is said of where she sends from."""

    name: str
    port: int = 0
    """Her own port here; 0: any."""
    sender: str = ""
    """The address of her machine; empty: any."""
    floor: bool = True
    """Whether her feet are brought down to the floor."""

    def suits(self, port: int, host: str) -> bool:
        """Whether a sender at `host` who sends to `port` may be her."""
        return self.port in (0, port) and self.sender in ("", host)

    @property
    def exactness(self) -> int:
        """How much is said: who is meant exactly comes first."""
        return 2 * bool(self.sender) + bool(self.port)


class Seats:
    """Who sits where. Thread: one."""

    def __init__(self, seats: tuple[Seat, ...]) -> None:
        """Without any there is one, `ALONE`."""
        self._seats = sorted(seats or (Seat(ALONE),), key=lambda seat: -seat.exactness)
        self._taken: dict[str, tuple[Hashable, float]] = {}

    def find(self, who: Hashable, port: int, host: str, now: float) -> Seat | None:
        """The seat of the sender `who`, at `host`, who sends to `port` at `now` [s]; None if there is none for her."""
        free = None
        for seat in self._seats:
            if not seat.suits(port, host):
                continue
            owner, last = self._taken.get(seat.name, (None, -GONE_AFTER))
            if owner == who:
                self._taken[seat.name] = who, now
                return seat
            if free is None and now - last >= GONE_AFTER:
                free = seat
        if free is not None:
            self._taken[free.name] = who, now
        return free


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


MOST_STREAMS: Final = 64


class VmcInput(CaptureInput):
    """Receives VMC on each of `endpoints` and puts the performers' poses into `lane`."""

    def __init__(
        self, endpoints: tuple[tuple[str, int], ...], seats: tuple[Seat, ...], lane: Lane[ControlEvent], clock: Clock
    ) -> None:
        """Nothing is opened yet. `seats`: the performers there may be."""
        super().__init__("vmc", clock, MAX_PACKET_BYTES)
        self._endpoints, self._lane = endpoints, lane
        self._seats = Seats(seats)
        self._wanted: tuple[Seat, ...] | None = None
        self._streams: dict[tuple[int, Any], VmcStream] = {}

    def open(self) -> list[socket.socket]:
        """See `CaptureInput`."""
        with ExitStack() as opened:
            sockets = [opened.enter_context(bound_socket(host, port, "--vmc")) for host, port in self._endpoints]
            opened.pop_all()
        return sockets

    def reseat(self, seats: tuple[Seat, ...]) -> None:
        """These are the performers from now on. Thread: any."""
        self._wanted = seats

    def hear(self, data: bytes, sender: Any, port: int, now: float) -> None:
        """See `CaptureInput`."""
        if self._wanted is not None:
            self._seats, self._wanted = Seats(self._wanted), None
        who = (port, sender)
        stream = self._streams.get(who)
        if stream is None:
            if len(self._streams) >= MOST_STREAMS and not self._make_room(now):
                self.rejected.count(Reason.SENDER)
                return
            stream = self._streams[who] = VmcStream(
                lambda time: self._seats.find(who, port, sender[0], time), self.rejected, self._lane.put
            )
        stream.hear(data, now)

    def _make_room(self, now: float) -> bool:
        """Forget senders of whom no pose has come for long; whether there were any."""
        gone = [who for who, stream in self._streams.items() if now - stream.last > GONE_AFTER]
        for who in gone:
            del self._streams[who]
        return bool(gone)

    def facts(self) -> dict[str, Any]:
        """For the status."""
        now = self.clock.now()
        streams = {
            stream.performer: {"from": f"{who[1][0]}:{who[1][1]}", **stream.facts(now)}
            for who, stream in tuple(self._streams.items())
            if stream.performer
        }
        return {**super().facts(), "performers": streams}
