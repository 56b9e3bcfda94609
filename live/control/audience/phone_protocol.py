"""What phones and gateway say to each other. Phones have six verbs, and no words of their own.

The first message is text, JSON of at most 256 bytes: `{"k": key}` of a link, `{"t": token}`, `{"v": voucher}` of who
was told to come again, with `"r"`: the region. Who cannot come in is told why, in how many seconds to ask again (0: not
with that), and her voucher: `{"no": why, "in": seconds, "v": voucher}`.
All others are bytes, little-endian, of one length for each verb: there is nothing to parse, and nothing to get wrong.
"""

import json
import struct
from dataclasses import dataclass
from typing import Final

import numpy as np

LONGEST: Final = 256
TOUCH: Final = 1
PING: Final = 2
VOTE: Final = 3
REGION: Final = 4
SHAKE: Final = 5
LENGTHS: Final = {TOUCH: 6, PING: 9, VOTE: 3, REGION: 2, SHAKE: 2}
"""Bytes of a message, the verb included."""
UP: Final = 0
ATTRACT: Final = 1
REPEL: Final = 2
"""Modes of a touch: the finger has gone; dancers shall come; dancers shall go."""
FULL_SCALE: Final = 65535.0

TOUCHES: Final = np.dtype([("verb", "u1"), ("mode", "u1"), ("x", "<u2"), ("z", "<u2")])
"""Touches in a row: x and z in parts of 65535 of the stage, from the left and from the back."""
_PONG: Final = struct.Struct("<B8sd")


@dataclass(frozen=True, slots=True)
class Hello:
    """The first message."""

    key: str = ""
    token: str = ""
    voucher: str = ""
    region: int = 0


def hello_of(text: str) -> Hello | None:
    """The first message; None for anything else."""
    if len(text) > LONGEST:
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
    """Whether a message is a verb with what belongs to it, its modes in range."""
    return bool(data) and LENGTHS.get(data[0]) == len(data) and (data[0] != TOUCH or data[1] <= REPEL)


def pong(data: bytes, now: float) -> bytes:
    """The answer to a ping: what it said (the phone's own clock), and the show's time [s]."""
    return _PONG.pack(PING, data[1:9], now)
