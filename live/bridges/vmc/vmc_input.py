"""VMC input over UDP: assigns senders to performers and assembles their bones into time-stamped poses."""

import math
import socket
from collections.abc import Callable, Hashable
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from live.base.event_queue import PriorityQueue
from live.bridges.vmc.vmc_protocol import MAX_PACKET_BYTES, Bone, decode_vmc
from live.clock.ticks import TICK
from live.clock.time_source import Clock
from live.control.events.capture import MocapFrame
from live.control.events.events import ControlEvent
from live.control.osc.osc_socket import bound_socket
from live.control.registry.rejections import Reason, Tally
from live.control.udp_input import CaptureInput
from live.motion.capture.captured_body import CapturedBody
from live.motion.skeleton import JOINT_COUNT
from live.show.patch.section_io import DEFAULT_PERFORMER

SEAT_TIMEOUT: Final = 2.0
"""A sender that is silent for this long [s] loses its seat to another one."""


@dataclass(frozen=True, slots=True)
class Seat:
    """A performer of the patch, with the conditions on the sender."""

    name: str
    port: int = 0
    """The performer's own port here; 0: any."""
    sender: str = ""
    """Address of the performer's computer; empty: any."""
    floor: bool = True
    """Whether the feet are moved down to the floor."""

    def accepts(self, port: int, host: str) -> bool:
        """Whether a sender at `host` that sends to `port` may be this performer."""
        return self.port in (0, port) and self.sender in ("", host)

    @property
    def specificity(self) -> int:
        """Number of conditions as a rank: seats with more conditions come first."""
        return 2 * bool(self.sender) + bool(self.port)


class Seats:
    """Assignment of senders to seats. Thread: one."""

    def __init__(self, seats: tuple[Seat, ...]) -> None:
        """Without seats there is a single one, of `DEFAULT_PERFORMER`."""
        self._seats = sorted(seats or (Seat(DEFAULT_PERFORMER),), key=lambda seat: -seat.specificity)
        self._taken: dict[str, tuple[Hashable, float]] = {}

    def find(self, who: Hashable, port: int, host: str, now: float) -> Seat | None:
        """Return the seat of sender `who`, at `host`, that sends to `port` at `now` [s]; None if there is none."""
        free = None
        for seat in self._seats:
            if not seat.accepts(port, host):
                continue
            owner, last = self._taken.get(seat.name, (None, -SEAT_TIMEOUT))
            if owner == who:
                self._taken[seat.name] = who, now
                return seat
            if free is None and now - last >= SEAT_TIMEOUT:
                free = seat
        if free is not None:
            self._taken[free.name] = who, now
        return free


MAX_DELAY: Final = 0.25
"""A pose with a longer apparent delay [s] is stamped with its arrival: the sender's clock has jumped."""
CLOCK_DRIFT: Final = 5e-4
"""Maximum relative drift between the clocks of two machines."""
MIN_INTERVAL: Final = 0.75 * TICK
"""Poses less than this [s] after the previous one are dropped: the show uses one per tick."""
MAX_SENDER_TIME: Final = 1e6
ALL_BONES: Final = (1 << JOINT_COUNT) - 1
"""All bones of the skeleton, one bit each."""


class VmcStream:
    """Stream of one sender, with one performer. Thread: one.

    A pose is complete when the usual bones have arrived. If its first bone, the hips, arrives again before that, a
    packet was lost and the pose is dropped. If the same bones were missing in the previous pose, the sender has no more
    bones.
    """

    def __init__(self, seat: Callable[[float], Seat | None], tally: Tally, send: Callable[[MocapFrame], None]) -> None:
        """`seat` returns the performer at a time [s]; `send` receives every pose."""
        self.performer = ""
        """The performer's name; empty before the first pose."""
        self.poses = 0
        """Complete poses so far."""
        self.is_tracked = True
        self.last = -math.inf
        """Time of the last pose [s]."""
        self._seat, self._tally, self._send = seat, tally, send
        self._body = CapturedBody()
        self._bones, self._known = np.zeros((JOINT_COUNT, 7)), np.zeros(JOINT_COUNT, np.bool_)
        self._bones[:, 3] = 1.0
        self._root = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        self._received_bits, self._expected_bits, self._dropped_bits = 0, ALL_BONES, 0
        self._now = 0.0
        self._sender_time: float | None = None
        self._min_offset, self._since = math.inf, 0.0

    @property
    def bones(self) -> int:
        """Number of received bones of the engine's skeleton."""
        return int(self._known.sum())

    def handle(self, data: bytes, now: float) -> None:
        """Handle a packet received at `now` [s]."""
        self._now = now
        decode_vmc(data, self, self._tally)
        if self._received_bits & self._expected_bits == self._expected_bits:
            self._finish_pose()

    # -- content of packets -------------------------------------------------------------------------------------------

    def bone(self, joint: int, bone: Bone) -> None:
        """See `vmc_protocol.Listener`."""
        bit = 1 << joint
        if self._received_bits & bit or (joint == 0 and self._received_bits):
            self._drop_pose()
        self._bones[joint], self._known[joint] = bone, True
        self._received_bits |= bit

    def root(self, bone: Bone) -> None:
        """See `vmc_protocol.Listener`."""
        self._root[:] = bone

    def tracked(self, on: bool) -> None:
        """See `vmc_protocol.Listener`."""
        self.is_tracked = on

    def sender_time(self, time: float) -> None:
        """See `vmc_protocol.Listener`."""
        if abs(time) < MAX_SENDER_TIME:
            self._sender_time = time

    def _drop_pose(self) -> None:
        """Handle bones of the next pose that arrive before the present pose is complete."""
        if not self._received_bits & 1:
            self._expected_bits |= self._received_bits  # an earlier loss had made the usual set too small
        elif self._received_bits == self._dropped_bits:
            self._expected_bits = self._received_bits
            self._finish_pose()
            return
        self._tally.count(Reason.TRUNCATED)
        self._dropped_bits, self._received_bits = self._received_bits, 0

    # -- complete poses ------------------------------------------------------------------------------------------------

    def _finish_pose(self) -> None:
        """Finish a complete pose and send it to the show if it is tracked."""
        self._received_bits = self._dropped_bits = 0
        time, self._sender_time = self._stamp(), None
        if not self.is_tracked or time - self.last < MIN_INTERVAL:
            return
        seat = self._seat(self._now)
        if seat is None:
            self._tally.count(Reason.SENDER)
            return
        self.performer = seat.name
        try:
            pose = self._body.pack(self._bones, self._known, self._root, time, find_floor=seat.floor)
        except ValueError:
            self._tally.count(Reason.OUT_OF_RANGE)
            return
        self.poses += 1
        self.last = time
        self._send(MocapFrame(time=time, source="vmc", performer=seat.name, pose=pose))

    def _stamp(self) -> float:
        """Return the capture time of the pose [s], by the sender's clock if available, as network delays vary.

        The packet with the shortest delay determines the offset between the clocks.
        """
        now = self._now
        if self._sender_time is None:
            return now
        apart = now - self._sender_time
        self._min_offset = min(self._min_offset + CLOCK_DRIFT * (now - self._since), apart)
        self._since = now
        if apart - self._min_offset > MAX_DELAY:
            self._min_offset = apart
        return self._sender_time + self._min_offset

    def facts(self, now: float) -> dict[str, Any]:
        """Return facts for the status."""
        ago = now - self.last
        return {
            "poses": self.poses, "bones": self.bones, "tracked": self.is_tracked,
            "last_s_ago": round(ago, 2) if math.isfinite(ago) else None,
        }  # fmt: skip


MOST_STREAMS: Final = 64


class VmcInput(CaptureInput):
    """Receives VMC on each of `endpoints` and puts the performers' poses into `lane`."""

    def __init__(
        self,
        endpoints: tuple[tuple[str, int], ...],
        seats: tuple[Seat, ...],
        lane: PriorityQueue[ControlEvent],
        clock: Clock,
    ) -> None:
        """Configure the input; nothing is opened yet. `seats`: the possible performers."""
        super().__init__("vmc", clock, MAX_PACKET_BYTES)
        self._endpoints, self._lane = endpoints, lane
        self._seats = Seats(seats)
        self._new_seats: tuple[Seat, ...] | None = None
        self._streams: dict[tuple[int, Any], VmcStream] = {}

    def open(self) -> list[socket.socket]:
        """See `CaptureInput`."""
        with ExitStack() as opened:
            sockets = [opened.enter_context(bound_socket(host, port, "--vmc")) for host, port in self._endpoints]
            opened.pop_all()
        return sockets

    def set_seats(self, seats: tuple[Seat, ...]) -> None:
        """Replace the performers. Thread: any."""
        self._new_seats = seats

    def handle(self, data: bytes, sender: Any, port: int, now: float) -> None:
        """See `CaptureInput`."""
        if self._new_seats is not None:
            self._seats, self._new_seats = Seats(self._new_seats), None
        who = (port, sender)
        stream = self._streams.get(who)
        if stream is None:
            if len(self._streams) >= MOST_STREAMS and not self._make_room(now):
                self.rejected.count(Reason.SENDER)
                return
            stream = self._streams[who] = VmcStream(
                lambda time: self._seats.find(who, port, sender[0], time), self.rejected, self._lane.put
            )
        stream.handle(data, now)

    def _make_room(self, now: float) -> bool:
        """Remove senders without recent poses; return whether there were any."""
        gone = [who for who, stream in self._streams.items() if now - stream.last > SEAT_TIMEOUT]
        for who in gone:
            del self._streams[who]
        return bool(gone)

    def status(self) -> dict[str, Any]:
        """Return facts for the status."""
        now = self.clock.now()
        streams = {
            stream.performer: {"from": f"{who[1][0]}:{who[1][1]}", **stream.facts(now)}
            for who, stream in tuple(self._streams.items())
            if stream.performer
        }
        return {**super().status(), "performers": streams}
