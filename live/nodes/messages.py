"""Messages between a leader and its render nodes: checked values, as MessagePack.

Nothing that comes from the bus can cause a call or an import (`live.control.message_codec`). A message of another kind
or with a wrong field is refused and counted by its reader.
"""

from dataclasses import dataclass, fields
from typing import Any, Final, TypeVar

from live.control.message_codec import PacketError, decode_packet, encode_packet, registered

LINES, PULSE, STATE, ORDER = "live/lines", "live/pulse", "live/state", "live/order"
"""Keys of what is published: by a leader, but for the state, which is by its nodes."""
CLOCK, JOIN, STATUS, COMMAND = "clock", "join", "status", "command"
"""What a leader answers, below its name: see `question_key`."""
MAX_MESSAGE: Final = 64 * 1024 * 1024
"""Most bytes of a message: what a machine that joins is sent of a long show without a snapshot."""

FARTHEST: Final = 1e12
"""Numbers beyond that, and those that are none, are refused: no clock shows them."""

Kind = TypeVar("Kind")


@registered("node.pulse")
@dataclass(frozen=True, slots=True)
class Pulse:
    """Regular sign of life of a leader, and its schedule: tick k is seen at `origin` + k / 64 s on its clock."""

    leader: str
    """Unique name of the leader's process."""
    epoch: int
    """The higher one rules (`live.supervisor.network.leadership`)."""
    show: str
    """Hash of the show's first line: leaders of one show, one after another, have the same."""
    stream: str
    number: int
    """Number of the last line sent in that stream."""
    origin: float
    """[s]"""
    ahead: float
    """How far before that time the leader runs a tick [s]."""


@registered("node.lines")
@dataclass(frozen=True, slots=True)
class Lines:
    """Lines of the show, as in the journal."""

    stream: str
    first: int
    """Number of the first one, from 1."""
    lines: tuple[str, ...]


@registered("node.asked")
@dataclass(frozen=True, slots=True)
class ClockAsked:
    """First half of an exchange of time stamps."""

    sent: float


@registered("node.told")
@dataclass(frozen=True, slots=True)
class ClockTold:
    """Second half; the first time is on the node's clock, the others on the leader's [s]."""

    sent: float
    received: float
    answered: float


@registered("node.join")
@dataclass(frozen=True, slots=True)
class Join:
    """Request for the show, from line `number` of `stream` on if it is still kept."""

    name: str
    """The node, as in the venue's file."""
    process: str
    """Unique name of its process."""
    version: str
    kernels: str
    """Its kernel set: other compiled code may round differently."""
    stream: str
    number: int


@registered("node.joined")
@dataclass(frozen=True, slots=True)
class Joined:
    """The show up to line `number` of `stream`: from its last snapshot if `restart`, else the lines missed."""

    stream: str
    number: int
    restart: bool
    lines: tuple[str, ...]


@registered("node.refused")
@dataclass(frozen=True, slots=True)
class Refused:
    """Why this node cannot draw the show, and what helps."""

    why: str
    remedy: str
    final: bool
    """Whether trying again is useless."""


@registered("node.state")
@dataclass(frozen=True, slots=True)
class NodeState:
    """Regular report of a node."""

    name: str
    process: str
    version: str
    state: str
    """searches, joins, follows, alone, refused, ended"""
    why: str = ""
    """What the operator has to know."""
    tick: int = 0
    """The last tick presented."""
    offset_ms: float = 0.0
    """The leader's clock minus this one."""
    rate_ppm: float = 0.0
    error_ms: float = 0.0
    round_trip_ms: float = 0.0
    discipline: str = ""
    """What disciplines this machine's clock."""
    frames: int = 0
    late: int = 0
    """Frames that showed an older tick than was due."""
    late_ms: float = 0.0
    """The most by which a frame was behind since the last report."""
    joins: int = 0
    """How often it took a snapshot."""
    compared: int = 0
    different: int = 0
    """Measures whose state was compared with the leader's, and those that differed."""
    refused: int = 0
    """Messages that were invalid."""
    outputs: str = ""
    """Its outputs, and what draws them."""


@registered("node.order")
@dataclass(frozen=True, slots=True)
class Order:
    """Request to a node: it starts again, and joins again."""

    name: str
    what: str = "restart"


@registered("node.status")
@dataclass(frozen=True, slots=True)
class ClusterStatus:
    """What a leader knows of its nodes."""

    leader: str
    version: str
    epoch: int
    tick: int
    leads: bool
    nodes: tuple[bytes, ...] = ()
    """Encoded `NodeState` of each."""
    ages: tuple[float, ...] = ()
    """Seconds since each was heard."""


def question_key(leader: str, what: str) -> str:
    """Return the key under which that leader answers; any leader for `*`."""
    return f"live/ask/{leader}/{what}"


def encode(message: Any) -> bytes:
    """Return a message as bytes."""
    return encode_packet(message)


def decode(data: bytes, kind: type[Kind]) -> Kind:
    """Return the message; PacketError if it is not a valid one of this kind."""
    if len(data) > MAX_MESSAGE:
        raise PacketError(f"a message of {len(data)} bytes; at most {MAX_MESSAGE}")
    found = decode_packet(data)
    if type(found) is not kind:
        raise PacketError(f"{kind.__name__} expected, {type(found).__name__} found")
    for each in fields(found):  # type: ignore[arg-type]
        value = getattr(found, each.name)
        if isinstance(value, float) and not abs(value) <= FARTHEST:
            raise PacketError(f"{kind.__name__}.{each.name} cannot be {value}")
    return found
