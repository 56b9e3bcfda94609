"""Wire format between phones and gateway. Phones have six verbs and cannot send free text.

The first message is JSON text of at most 256 bytes: `{"k": key}` from a link, `{"t": token}`, or `{"v": voucher}` of a
phone that was asked to return, with `"r"`: the region. A refused phone gets the reason, the seconds until its next
attempt (0: not with these credentials) and its voucher: `{"no": why, "in": seconds, "v": voucher}`. All other messages
are little-endian bytes with a fixed length for each verb, so no parser is needed.
"""

import json
import struct
from dataclasses import dataclass
from typing import Final

import numpy as np

MAX_HELLO_CHARS: Final = 256
TOUCH: Final = 1
PING: Final = 2
VOTE: Final = 3
REGION: Final = 4
SHAKE: Final = 5
LENGTHS: Final = {TOUCH: 6, PING: 9, VOTE: 3, REGION: 2, SHAKE: 2}
"""Message length of each verb [bytes], including the verb."""
UP: Final = 0
ATTRACT: Final = 1
REPEL: Final = 2
"""Modes of a touch: finger lifted, attract dancers, repel dancers."""
FULL_SCALE: Final = 65535.0

TOUCH_DTYPE: Final = np.dtype([("verb", "u1"), ("mode", "u1"), ("x", "<u2"), ("z", "<u2")])
"""Array type of touches: x and z in 1/65535 of the stage, from the left and from the back."""
_PONG: Final = struct.Struct("<B8sd")


@dataclass(frozen=True, slots=True)
class Hello:
    """Content of a phone's first message."""

    key: str = ""
    token: str = ""
    voucher: str = ""
    region: int = 0


def parse_hello(text: str) -> Hello | None:
    """Parse the first message; None for anything else."""
    if len(text) > MAX_HELLO_CHARS:
        return None
    try:
        said = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if type(said) is not dict or not set(said) <= {"k", "t", "v", "r"}:
        return None
    key, token, voucher, region = said.get("k", ""), said.get("t", ""), said.get("v", ""), said.get("r", 0)
    if type(key) is not str or type(token) is not str or type(voucher) is not str:
        return None
    if type(region) is not int or not 0 <= region < 64 or not (key + token + voucher).isascii():
        return None
    return Hello(key, token, voucher, region) if key or token or voucher else None


def is_well_formed(data: bytes) -> bool:
    """Whether a message has a known verb, its length, and a mode in range."""
    return bool(data) and LENGTHS.get(data[0]) == len(data) and (data[0] != TOUCH or data[1] <= REPEL)


def pong(data: bytes, now: float) -> bytes:
    """Return the answer to a ping: its payload (the phone's clock) and the show's time [s]."""
    return _PONG.pack(PING, data[1:9], now)
