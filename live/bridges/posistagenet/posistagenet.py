"""PosiStageNet 2 decoder and UDP input: positions and names of trackers from a tracking system.

The format is little endian. A packet is one chunk. A chunk has a 32-bit header (16 bits identity, 15 bits length, 1 bit
for nested chunks) and data. Data packets give each tracker's position and validity, info packets the names. Unknown
chunks are skipped, as the protocol requires. A packet with inconsistent chunk sizes is refused as a whole, a tracker
with invalid numbers on its own; both are counted. The show gets at most one position of each tracker per frame.

Source: PosiStageNet protocol 2.03 (VYV, MA Lighting).
"""

import ipaddress
import math
import socket
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final

from live.base.event_queue import PriorityQueue
from live.clock.ticks import TICK
from live.clock.time_source import Clock
from live.control.events.capture import TrackerMoved
from live.control.events.events import ControlEvent
from live.control.osc.osc_socket import CannotListen, bound_socket
from live.control.registry.rejections import Reason, Tally
from live.control.udp_input import CaptureInput

MAX_PACKET_BYTES: Final = 8192
"""The protocol sends at most 1500."""
MAX_COORDINATE: Final = 1000.0
"""Maximum coordinate of a tracker [m]."""
NAME_LENGTH: Final = 64
DATA: Final = 0x6755
INFO: Final = 0x6756
_HEADER: Final = 0
_DATA_TRACKERS: Final = 1
_INFO_TRACKERS: Final = 2
_PLACE: Final = 0
_STATUS: Final = 3
_NAME: Final = 0
_VERSION: Final = 2
_CHUNK = struct.Struct("<I")
_FRAME = struct.Struct("<Q4B")
_VECTOR = struct.Struct("<3f")
_FLOAT = struct.Struct("<f")

Place = tuple[float, float, float]


class PsnRefused(Exception):
    """A packet refused as a whole, for `reason`."""

    def __init__(self, reason: Reason) -> None:
        super().__init__(reason)
        self.reason = reason


@dataclass(frozen=True, slots=True)
class PsnPacket:
    """Content of one packet."""

    time: int
    """The server's time of the frame [µs]."""
    frame: int
    packets: int
    """Number of packets of the frame."""
    places: dict[int, Place] = field(default_factory=dict)
    """Positions of valid trackers by number, in the system's axes [m]."""
    names: dict[int, str] = field(default_factory=dict)
    """Names of trackers by number."""
    is_data: bool = True


def decode_psn(data: bytes, tally: Tally) -> PsnPacket | None:
    """Decode a packet; None, counted, if it is refused."""
    try:
        if not 0 < len(data) <= MAX_PACKET_BYTES:
            raise PsnRefused(Reason.PACKET_SIZE)
        (root,) = _chunks(data, 0, len(data), most=1)
        if root[0] not in (DATA, INFO):
            raise PsnRefused(Reason.UNKNOWN_TYPE)
        return _packet(data, root, tally)
    except PsnRefused as error:
        tally.count(error.reason)
    except ValueError:  # not exactly one chunk
        tally.count(Reason.TRAILING)
    return None


Chunk = tuple[int, int, int, bool]
"""Identity, begin and end of its data, and whether it has nested chunks."""


def _chunks(data: bytes, start: int, stop: int, most: int = 512) -> Iterator[Chunk]:
    """Return the chunks that fill data[start:stop]; PsnRefused if one does not fit."""
    while start < stop:
        if start + _CHUNK.size > stop or most <= 0:
            raise PsnRefused(Reason.TRUNCATED if most > 0 else Reason.TRAILING)
        (head,) = _CHUNK.unpack_from(data, start)
        begin = start + _CHUNK.size
        start, most = begin + ((head >> 16) & 0x7FFF), most - 1
        if start > stop:
            raise PsnRefused(Reason.ELEMENT_SIZE)
        yield head & 0xFFFF, begin, start, bool(head >> 31)


def _nested_chunks(data: bytes, chunk: Chunk) -> Iterator[Chunk]:
    """Return the nested chunks of one that must have some; PsnRefused if it has none."""
    if not chunk[3]:
        raise PsnRefused(Reason.WRONG_TYPE)
    return _chunks(data, chunk[1], chunk[2])


def _packet(data: bytes, root: Chunk, tally: Tally) -> PsnPacket:
    header: Chunk | None = None
    places: dict[int, Place] = {}
    names: dict[int, str] = {}
    for chunk in _nested_chunks(data, root):
        if chunk[0] == _HEADER:
            header = chunk
        elif root[0] == DATA and chunk[0] == _DATA_TRACKERS:
            for tracker in _nested_chunks(data, chunk):
                place = _place(data, tracker, tally)
                if place is not None:
                    places[tracker[0]] = place
        elif root[0] == INFO and chunk[0] == _INFO_TRACKERS:
            for tracker in _nested_chunks(data, chunk):
                name = _name(data, tracker, tally)
                if name is not None:
                    names[tracker[0]] = name
    if header is None:
        raise PsnRefused(Reason.MISSING)
    if header[3] or header[2] - header[1] != _FRAME.size:
        raise PsnRefused(Reason.WRONG_TYPE)
    time, high, _, frame, packets = _FRAME.unpack_from(data, header[1])
    if high != _VERSION:
        raise PsnRefused(Reason.UNKNOWN_TYPE)
    return PsnPacket(time, frame, packets, places, names, root[0] == DATA)


def _place(data: bytes, tracker: Chunk, tally: Tally) -> Place | None:
    """Return a tracker's position; None if it is missing, marked as invalid, or (counted) impossible."""
    place: Place | None = None
    valid = True
    for identity, begin, end, nested in _nested_chunks(data, tracker):
        if identity == _PLACE:
            if nested or end - begin != _VECTOR.size:
                raise PsnRefused(Reason.WRONG_TYPE)
            place = _VECTOR.unpack_from(data, begin)
        elif identity == _STATUS:
            if nested or end - begin != _FLOAT.size:
                raise PsnRefused(Reason.WRONG_TYPE)
            valid = _FLOAT.unpack_from(data, begin)[0] > 0.0
    if place is None or not valid:
        return None
    if not math.isfinite(sum(place)):
        tally.count(Reason.NOT_FINITE)
        return None
    if max(map(abs, place)) > MAX_COORDINATE:
        tally.count(Reason.OUT_OF_RANGE)
        return None
    return place


def _name(data: bytes, tracker: Chunk, tally: Tally) -> str | None:
    """Return a tracker's name; None if it is missing or (counted) invalid."""
    for identity, begin, end, nested in _nested_chunks(data, tracker):
        if identity != _NAME:
            continue
        if nested:
            raise PsnRefused(Reason.WRONG_TYPE)
        try:
            name = data[begin:end].rstrip(b"\0").decode("utf-8").strip()
        except UnicodeDecodeError:
            tally.count(Reason.TEXT)
            return None
        if 0 < len(name) <= NAME_LENGTH and name.isprintable():
            return name
        tally.count(Reason.NAME)
    return None


GROUP: Final = "236.10.10.10"
PORT: Final = 56565
MOST_TRACKERS: Final = 128
MIN_MOVE: Final = 0.002
"""A tracker that has moved less than this [m] is sent again only after …"""
REPEAT_INTERVAL: Final = 0.1
"""… this time [s], as a sign that it is present."""
MIN_INTERVAL: Final = 0.75 * TICK
"""Positions less than this [s] after the previous one are dropped: the show uses one per tick."""
RESTART_AGE_US: Final = 10_000_000
"""A frame older than the last one by less than this [µs] is late; by more, the server has restarted."""


class PsnFrames:
    """Joins the packets of frames. Thread: one."""

    def __init__(self, tally: Tally) -> None:
        self._tally = tally
        self._places: dict[int, Place] = {}
        self._frame, self._packet_count, self._time = -1, 0, -RESTART_AGE_US
        self.names: dict[int, str] = {}
        """Names of trackers by number."""
        self.frames = 0
        """Frames so far."""

    def add(self, packet: PsnPacket) -> dict[int, Place]:
        """Handle a packet; return the positions of a frame that is complete, or ended by the next frame."""
        if not packet.is_data:
            for number, name in packet.names.items():
                if number in self.names or len(self.names) < MOST_TRACKERS:
                    self.names[number] = name
            return {}
        if 0 < self._time - packet.time < RESTART_AGE_US:
            self._tally.count(Reason.OUT_OF_RANGE)
            return {}
        ended: dict[int, Place] = {}
        if (packet.frame, packet.time) != (self._frame, self._time):
            ended, self._places = self._places, {}  # the remainder of a frame that lost a packet
            self._frame, self._time, self._packet_count = packet.frame, packet.time, 0
        self._places |= packet.places
        self._packet_count += 1
        if self._packet_count >= packet.packets:
            whole, self._places = self._places, {}
            self.frames += 1
            return {**ended, **whole}
        return ended


@dataclass(slots=True)
class _SentPosition:
    place: Place = (0.0, 0.0, 0.0)
    time: float = field(default=-1e9)


class PsnInput(CaptureInput):
    """Receives PosiStageNet on a port, optionally of a multicast group, and puts tracker positions into `lane`."""

    def __init__(self, host: str, port: int, interface: str, lane: PriorityQueue[ControlEvent], clock: Clock) -> None:
        """Configure the input; nothing is opened yet.

        `interface`: address of the network card on which to join a group; empty: chosen by the system.
        """
        super().__init__("psn", clock, MAX_PACKET_BYTES)
        self._host, self._port, self._interface, self._lane = host, port, interface, lane
        self._frames = PsnFrames(self.rejected)
        self._sent: dict[int, _SentPosition] = {}

    def open(self) -> list[socket.socket]:
        """See `CaptureInput`."""
        try:
            group = ipaddress.ip_address(self._host).is_multicast
        except ValueError:
            group = False
        if not group:
            return [bound_socket(self._host, self._port, "--psn")]
        return [_group_socket(self._host, self._port, self._interface)]

    def handle(self, data: bytes, sender: Any, port: int, now: float) -> None:
        """See `CaptureInput`."""
        packet = decode_psn(data, self.rejected)
        if packet is None:
            return
        for number, place in self._frames.add(packet).items():
            self._send_position(number, place, now)

    def _send_position(self, number: int, place: Place, now: float) -> None:
        """Send a tracker's position if it has changed enough."""
        told = self._sent.get(number)
        if told is None:
            if len(self._sent) >= MOST_TRACKERS:
                self.rejected.count(Reason.MANY_MESSAGES)
                return
            told = self._sent[number] = _SentPosition()
        if now - told.time < MIN_INTERVAL:
            return
        if (
            now - told.time < REPEAT_INTERVAL
            and max(abs(a - b) for a, b in zip(place, told.place, strict=True)) < MIN_MOVE
        ):
            return
        told.place, told.time = place, now
        name = self._frames.names.get(number, str(number))
        x, y, z = (round(value, 4) for value in place)  # the journal stores the same values that the show uses
        self._lane.put(TrackerMoved(time=now, source="psn", tracker=name, x=x, y=y, z=z))

    def status(self) -> dict[str, Any]:
        """Return facts for the status."""
        now = self.clock.now()
        trackers = {
            self._frames.names.get(number, str(number)): round(now - told.time, 2)
            for number, told in tuple(self._sent.items())
        }
        return {**super().status(), "frames": self._frames.frames, "trackers_last_s_ago": trackers}


def _group_socket(group: str, port: int, interface: str) -> socket.socket:
    """Return a socket in a multicast group; CannotListen if that fails."""
    sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # others may also join the group
        sock.setblocking(False)
        sock.bind((group, port))
        member = struct.pack("4s4s", socket.inet_aton(group), socket.inet_aton(interface or "0.0.0.0"))
        sock.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
    except OSError as error:
        sock.close()
        raise CannotListen(
            f"PosiStageNet cannot be received on {group}:{port}: {error.strerror or error}; is there a network? "
            f"--psn {group}:{port}@ADDRESS names the card by its address"
        ) from None
    return sock
