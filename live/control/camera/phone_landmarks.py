"""Landmarks that a phone's browser sends: their packets, and who gets them in the show.

The model runs on the phone (`live.control.web.camera_pages`); a packet has the joints of one picture and no picture.
All numbers are little endian. The head: version (uint8), 1 if a person was found (uint8), a count of the pictures
(uint16, wraps), capture time in show time [s] (float64), presence (uint8, of 255), width of the picture over its height
(uint16, of 4096). With a person, for each of the 33 landmarks: place in the picture (2 int16, of 8192), body (3 int16,
of 10 000 [m]), visibility (uint8, of 255). Rounding moves a place by at most 0.00007 of the picture, the body by
0.05 mm.
"""

import math
import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final, TypeAlias

import numpy as np

from live.motion.capture.landmarks import LANDMARK_COUNT, Landmarks

VERSION: Final = 1
_HEAD: Final = struct.Struct("<BBHdBH")
_POINT: Final = np.dtype([("picture", "<i2", 2), ("body", "<i2", 3), ("visibility", "u1")])
EMPTY_BYTES: Final = _HEAD.size
"""Bytes of a packet in which nobody is seen."""
PACKET_BYTES: Final = _HEAD.size + LANDMARK_COUNT * _POINT.itemsize
"""Bytes of a packet with a person."""
PICTURE_UNITS: Final = 8192.0
BODY_UNITS: Final = 10_000.0
ASPECT_UNITS: Final = 4096.0
MAX_TIME: Final = 1e7
"""Largest time of a capture [s]."""
MIN_ASPECT, MAX_ASPECT = 0.2, 5.0


@dataclass(frozen=True, slots=True, eq=False)
class PhonePicture:
    """What a phone says of one picture."""

    count: int
    """Number of the picture, 0 to 65 535, from 0 again."""
    time: float
    """Capture time in show time [s]."""
    landmarks: Landmarks | None
    """None: nobody is seen."""


def decode_landmarks(data: bytes) -> PhonePicture:
    """Decode a packet; ValueError, with the reason, for anything else."""
    if len(data) not in (EMPTY_BYTES, PACKET_BYTES):
        raise ValueError(f"{EMPTY_BYTES} or {PACKET_BYTES} bytes expected")
    version, seen, count, time, presence, aspect = _HEAD.unpack_from(data)
    if version != VERSION:
        raise ValueError("another version of the page: load it again")
    if seen not in (0, 1) or bool(seen) != (len(data) == PACKET_BYTES):
        raise ValueError("length and content do not agree")
    if not math.isfinite(time) or not 0.0 <= time <= MAX_TIME:
        raise ValueError("the capture time is out of range")
    if not seen:
        return PhonePicture(count, time, None)
    if not MIN_ASPECT <= aspect / ASPECT_UNITS <= MAX_ASPECT:
        raise ValueError("the shape of the picture is out of range")
    points = np.frombuffer(data, _POINT, LANDMARK_COUNT, _HEAD.size)
    picture = (points["picture"] / PICTURE_UNITS).astype(np.float32)
    body = (points["body"] / BODY_UNITS).astype(np.float32)
    visibility = (points["visibility"] / 255.0).astype(np.float32)
    found = Landmarks(time, picture, body, visibility, presence / 255.0, aspect / ASPECT_UNITS)
    return PhonePicture(count, time, found)


PhoneHandler: TypeAlias = Callable[[str, str, bytes, float], None]
"""Takes a packet that can be decoded: name of the phone, performer, the packet, show time of its arrival [s]."""


@dataclass(eq=False)
class PhoneCameras:
    """The phones that are cameras of a show, for the service that makes bodies of what they see. Thread: the show's."""

    handlers: list[PhoneHandler] = field(default_factory=list)
    """Called with every packet, before the frame."""
    packets: int = 0
    """Packets so far."""

    def take(self, phone: str, performer: str, packet: bytes, arrival: float) -> None:
        """Pass a packet on."""
        self.packets += 1
        for handle in self.handlers:
            handle(phone, performer, packet, arrival)
