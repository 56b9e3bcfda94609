"""Packets between gateways and the reducer.

Each is a registered object (`message_codec`), except what is sent in each tick: `pack_voices`. The reducer passes on
the show's own packets (`Rules`, `BeatClock`, the stage) as they are.
"""

import struct
from dataclasses import dataclass, field
from typing import Final

from live.control.audience.voice_report import VoiceReport
from live.control.audience.voice_sketch import VoiceSketch
from live.control.events.audience import VoiceLight
from live.control.message_codec import registered

PROTOCOL: Final = 1
"""Version of these packets."""
MAX_ROWS: Final = 512
"""Most rows of a packet; the others follow in the next ones."""
VOICES: Final = ord("V")
"""First byte of `pack_voices`; no registered object begins with it."""
_VOICES: Final = struct.Struct("<BIII")

GroupRow = tuple[int, int, int, float]
"""A group's number, how many phones are in it, how many joined in it, and until when it is crowded [s of the show]."""


def pack_voices(report: VoiceReport) -> bytes:
    """Return what a gateway tells in each tick: what it hears."""
    return _VOICES.pack(VOICES, report.order, report.phones, report.speaking) + report.sketch.encode()


def unpack_voices(data: bytes) -> VoiceReport:
    """Return a report without lights and votes; ValueError for bytes that are none."""
    if len(data) < _VOICES.size:
        raise ValueError("a gateway's voices expected")
    _, order, phones, speaking = _VOICES.unpack_from(data)
    return VoiceReport(order, phones, speaking, VoiceSketch.decode(data[_VOICES.size :]))


@registered("shard hello")
@dataclass(frozen=True, slots=True)
class ShardHello:
    """First packet of a gateway."""

    protocol: int
    version: str
    """Of the program."""
    name: str
    """Name of the gateway, which it keeps while it runs."""
    capacity: int
    """Most phones at a time."""
    highest: int
    """Highest number of a phone that it knows."""


@registered("shard plan")
@dataclass(frozen=True, slots=True)
class ShardPlan:
    """Answer to the hello: what a gateway has to know of the show. It has the show's secret: paired machines get it."""

    time: float
    """Time of the show [s]."""
    secret: bytes = field(repr=False)
    link: str
    """The address that phones open."""
    most: int
    """Most phones at a time of this gateway ..."""
    most_in_all: int
    """... and of all together."""
    per_address: int
    network: str
    proxies: tuple[str, ...]
    by_card: bool
    code_s: float
    grace_s: float
    joins_per_code: int
    """0: twice the phones."""


@registered("shard refused")
@dataclass(frozen=True, slots=True)
class ShardRefused:
    """Answer to a gateway that does not fit."""

    why: str


@registered("shard shown")
@dataclass(frozen=True, slots=True)
class ShardShown:
    """A gateway's highlights and votes, when they change."""

    lights: tuple[VoiceLight, ...]
    votes: tuple[int, ...]


@registered("shard changes")
@dataclass(frozen=True, slots=True)
class ShardChanges:
    """Groups of a gateway that changed, and numbers of phones that came and went."""

    groups: tuple[GroupRow, ...] = ()
    came: tuple[int, ...] = ()
    went: tuple[int, ...] = ()


@registered("shard others")
@dataclass(frozen=True, slots=True)
class ShardOthers:
    """What the other gateways have of groups that this one has phones of, and numbers that are connected elsewhere."""

    groups: tuple[GroupRow, ...] = ()
    gone: tuple[int, ...] = ()


@registered("shard numbers")
@dataclass(frozen=True, slots=True)
class ShardNumbers:
    """Numbers for new phones: from `first` up to `end`."""

    first: int
    end: int


@registered("shard state")
@dataclass(frozen=True, slots=True)
class SharedState:
    """State of all gateways together, several times a second."""

    elsewhere: int
    """Phones of the other gateways."""
    visible: int
    """How many lights this gateway has."""
    tally: tuple[int, ...]
    """Votes of all gateways, as in `VoiceReport.tally`."""


@registered("shard ping")
@dataclass(frozen=True, slots=True)
class ShardPing:
    """A gateway's clock [s]; it comes back with the show's time."""

    sent: float
    show: float = 0.0
