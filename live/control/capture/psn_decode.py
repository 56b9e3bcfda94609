"""PosiStageNet 2: packets of a tracking system as places of trackers and their names.

Little endian; a packet is one chunk, a chunk a header of 32 bits (16 of an identity, 15 of a length, 1 that says
whether chunks are within) and its data. Of data packets the place of each tracker is read and whether it is valid, of
info packets the names; chunks that are not known are passed over, as the protocol wants it. A packet whose chunks do
not fit into each other is refused whole, a tracker whose numbers cannot be for itself alone; both are counted.

Source: PosiStageNet protocol 2.03 (VYV, MA Lighting).
"""

import math
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

from live.control.registry.rejections import Reason, Tally

MAX_PACKET_BYTES: Final = 8192
"""The protocol sends 1500 at most."""
FARTHEST: Final = 1000.0
"""No tracker is farther from the origin [m]."""
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
    """A packet that is refused as a whole, for `reason`."""

    def __init__(self, reason: Reason) -> None:
        super().__init__(reason)
        self.reason = reason


@dataclass(frozen=True, slots=True)
class PsnPacket:
    """What one packet says."""

    time: int
    """The server's time of the frame [µs]."""
    frame: int
    packets: int
    """Packets that the frame has."""
    places: dict[int, Place] = field(default_factory=dict)
    """Where trackers are, by their numbers, in the system's axes [m]; only of those that are valid."""
    names: dict[int, str] = field(default_factory=dict)
    """What trackers are called."""
    is_data: bool = True


def read_psn(data: bytes, tally: Tally) -> PsnPacket | None:
    """What a packet says; None, counted, if it is refused."""
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
"""Identity, where its data begins and ends, whether chunks are within."""


def _chunks(data: bytes, start: int, stop: int, most: int = 512) -> Iterator[Chunk]:
    """The chunks that fill data[start:stop]; PsnRefused where one does not fit."""
    while start < stop:
        if start + _CHUNK.size > stop or most <= 0:
            raise PsnRefused(Reason.TRUNCATED if most > 0 else Reason.TRAILING)
        (head,) = _CHUNK.unpack_from(data, start)
        begin = start + _CHUNK.size
        start, most = begin + ((head >> 16) & 0x7FFF), most - 1
        if start > stop:
            raise PsnRefused(Reason.ELEMENT_SIZE)
        yield head & 0xFFFF, begin, start, bool(head >> 31)


def _within(data: bytes, chunk: Chunk) -> Iterator[Chunk]:
    """The chunks within one that must have some; PsnRefused if it is said to have none."""
    if not chunk[3]:
        raise PsnRefused(Reason.WRONG_TYPE)
    return _chunks(data, chunk[1], chunk[2])


def _packet(data: bytes, root: Chunk, tally: Tally) -> PsnPacket:
    header: Chunk | None = None
    places: dict[int, Place] = {}
    names: dict[int, str] = {}
    for chunk in _within(data, root):
        if chunk[0] == _HEADER:
            header = chunk
        elif root[0] == DATA and chunk[0] == _DATA_TRACKERS:
            for tracker in _within(data, chunk):
                place = _place(data, tracker, tally)
                if place is not None:
                    places[tracker[0]] = place
        elif root[0] == INFO and chunk[0] == _INFO_TRACKERS:
            for tracker in _within(data, chunk):
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
    """Where a tracker is; None if it does not say, says that it does not know, or (counted) what cannot be."""
    place: Place | None = None
    valid = True
    for identity, begin, end, nested in _within(data, tracker):
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
    if max(map(abs, place)) > FARTHEST:
        tally.count(Reason.OUT_OF_RANGE)
        return None
    return place


def _name(data: bytes, tracker: Chunk, tally: Tally) -> str | None:
    """What a tracker is called; None if it is not said, or (counted) is no name."""
    for identity, begin, end, nested in _within(data, tracker):
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
