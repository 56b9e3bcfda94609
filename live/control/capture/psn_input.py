"""PosiStageNet over UDP: where trackers are goes into the show's inbox, of each the newest place of a frame."""

import ipaddress
import socket
import struct
from dataclasses import dataclass, field
from typing import Any, Final

from live.base.lane import Lane
from live.clock.ticks import TICK
from live.clock.time_source import Clock
from live.control.capture.psn_decode import MAX_PACKET_BYTES, Place, PsnPacket, read_psn
from live.control.capture.udp_input import CaptureInput
from live.control.events.capture import TrackerMoved
from live.control.events.events import ControlEvent
from live.control.osc.osc_socket import CannotListen, bound_socket
from live.control.registry.rejections import Reason, Tally

GROUP: Final = "236.10.10.10"
PORT: Final = 56565
MOST_TRACKERS: Final = 128
STILL: Final = 0.002
"""A tracker that has moved less than this [m] is told again only after ..."""
STILL_S: Final = 0.1
"""... so many seconds, as a sign that it is there."""
THIN: Final = 0.75 * TICK
"""Places that come sooner after another [s] are left out: the show takes one a tick."""
OLD_US: Final = 10_000_000
"""A frame that is older than the last one by less than this [µs] comes late; by more, the server began anew."""


class PsnFrames:
    """Puts the packets of frames together. Thread: one."""

    def __init__(self, tally: Tally) -> None:
        self._tally = tally
        self._places: dict[int, Place] = {}
        self._frame, self._seen, self._time = -1, 0, -OLD_US
        self.names: dict[int, str] = {}
        """What trackers are called, by their numbers."""
        self.frames = 0
        """Frames so far."""

    def take(self, packet: PsnPacket) -> dict[int, Place]:
        """Take up a packet; returns the places of a frame that is whole now, or that another one has ended."""
        if not packet.is_data:
            for number, name in packet.names.items():
                if number in self.names or len(self.names) < MOST_TRACKERS:
                    self.names[number] = name
            return {}
        if 0 < self._time - packet.time < OLD_US:
            self._tally.count(Reason.OUT_OF_RANGE)
            return {}
        ended: dict[int, Place] = {}
        if (packet.frame, packet.time) != (self._frame, self._time):
            ended, self._places = self._places, {}  # what is left of a frame that lost a packet
            self._frame, self._time, self._seen = packet.frame, packet.time, 0
        self._places |= packet.places
        self._seen += 1
        if self._seen >= packet.packets:
            whole, self._places = self._places, {}
            self.frames += 1
            return {**ended, **whole}
        return ended


@dataclass(slots=True)
class _Told:
    place: Place = (0.0, 0.0, 0.0)
    time: float = field(default=-1e9)


class PsnInput(CaptureInput):
    """Receives PosiStageNet at a port, of a multicast group or not, and puts trackers' places into `lane`."""

    def __init__(self, host: str, port: int, interface: str, lane: Lane[ControlEvent], clock: Clock) -> None:
        """Nothing is opened yet. `interface`: the address of the network card on which a group is joined; empty: the
        one that the system chooses."""
        super().__init__("psn", clock, MAX_PACKET_BYTES)
        self._host, self._port, self._interface, self._lane = host, port, interface, lane
        self._frames = PsnFrames(self.rejected)
        self._told: dict[int, _Told] = {}

    def open(self) -> list[socket.socket]:
        """See `CaptureInput`."""
        try:
            group = ipaddress.ip_address(self._host).is_multicast
        except ValueError:
            group = False
        if not group:
            return [bound_socket(self._host, self._port, "--psn")]
        return [_group_socket(self._host, self._port, self._interface)]

    def hear(self, data: bytes, sender: Any, port: int, now: float) -> None:
        """See `CaptureInput`."""
        packet = read_psn(data, self.rejected)
        if packet is None:
            return
        for number, place in self._frames.take(packet).items():
            self._tell(number, place, now)

    def _tell(self, number: int, place: Place, now: float) -> None:
        """Where a tracker is, if that is news."""
        told = self._told.get(number)
        if told is None:
            if len(self._told) >= MOST_TRACKERS:
                self.rejected.count(Reason.MANY_MESSAGES)
                return
            told = self._told[number] = _Told()
        if now - told.time < THIN:
            return
        if now - told.time < STILL_S and max(abs(a - b) for a, b in zip(place, told.place, strict=True)) < STILL:
            return
        told.place, told.time = place, now
        name = self._frames.names.get(number, str(number))
        x, y, z = (round(value, 4) for value in place)  # what the journal has is what the show sees
        self._lane.put(TrackerMoved(time=now, source="psn", tracker=name, x=x, y=y, z=z))

    def facts(self) -> dict[str, Any]:
        """For the status."""
        now = self.clock.now()
        trackers = {
            self._frames.names.get(number, str(number)): round(now - told.time, 2)
            for number, told in tuple(self._told.items())
        }
        return {**super().facts(), "frames": self._frames.frames, "trackers_last_s_ago": trackers}


def _group_socket(group: str, port: int, interface: str) -> socket.socket:
    """A socket that hears a multicast group; CannotListen if that cannot be."""
    sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # others may hear the group, too
        sock.setblocking(False)
        sock.bind((group, port))
        member = struct.pack("4s4s", socket.inet_aton(group), socket.inet_aton(interface or "0.0.0.0"))
        sock.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
    except OSError as error:
        sock.close()
        raise CannotListen(
            f"PosiStageNet cannot be heard on {group}:{port}: {error.strerror or error}; is there a network? "
            f"--psn {group}:{port}@ADDRESS names the card by its address"
        ) from None
    return sock
