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


@registered("cluster.member")
@dataclass(frozen=True, slots=True)
class Member:
    """What a leader knows of a part of the show that is no node: the supervisor or the engine has a link of its own
    to it."""

    kind: str
    """standby, gateway, reducer"""
    name: str
    process: str
    """Differs once it has been started again."""
    version: str
    state: str
    """ready, follows; serves, silent, gone, refused"""
    why: str = ""
    """What the operator has to know."""
    machine: str = ""
    """Where it runs: the name of a paired machine, or the begin of its certificate's fingerprint; empty: here."""
    offset_ms: float = 0.0
    """Error of its clock before the last correction."""
    late_ms: float = 0.0
    """Of a gateway: lateness of its ticks (99 of 100 are less late); of a standby: how far it is behind the leader."""
    silent_ms: float = 0.0
    """Since when nothing has been heard of it."""
    load: str = ""
    """What it carries."""


@registered("node.order")
@dataclass(frozen=True, slots=True)
class Order:
    """Request to a part of the show: it starts again, and joins again."""

    name: str
    kind: str = "node"
    """node, or that of a `Member`"""
    process: str = ""
    """Which one of this name; empty: each."""


@registered("node.status")
@dataclass(frozen=True, slots=True)
class ClusterStatus:
    """What a leader knows of its nodes and of the other parts of its show."""

    leader: str
    version: str
    epoch: int
    tick: int
    leads: bool
    nodes: tuple[bytes, ...] = ()
    """Encoded `NodeState` of each."""
    ages: tuple[float, ...] = ()
    """Seconds since each was heard."""
    members: tuple[bytes, ...] = ()
    """Encoded `Member` of each standby, gateway and reducer."""
    refused: int = 0
    """Invalid messages; ..."""
    strangers: int = 0
    """... and those that no paired machine has signed."""


@registered("page.frame")
@dataclass(frozen=True, slots=True)
class PageFrame:
    """Part of a connection of a browser that is relayed (`live.nodes.page_relay`)."""

    connection: bytes
    """Its random number."""
    sender: str
    """The end that sends: answers go to its key."""
    kind: str
    """data, end (no more data), ack, lost (as ack, and something was missing), ask (for an ack), reset"""
    offset: int
    """Of data and end: its place among all bytes of this direction. Of the others: up to where all have arrived."""
    read: int = 0
    """Up to where they have been handed on."""
    data: bytes = b""


def page_key(end: str) -> str:
    """Return the key under which this end of relayed connections receives."""
    return f"live/page/{end}"


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
