"""Messages between machines other than the show's own lines, as JSON lines that are parsed strictly.

A claim is signed by its sender, over a challenge that the receiver made for this connection and an increasing number.
So a claim made for another machine, for another connection, or earlier is worthless.
"""

import json
import math
from dataclasses import dataclass, field
from typing import Any, Final

from live.supervisor.network.identity import Identity, Peer
from live.supervisor.network.leadership import Claim, HandOver, Message, Pulse, Term

CONTEXT: Final = "choreographics-live claim 1"
CHALLENGE: Final = 32
"""Bytes."""
LONGEST_NAME: Final = 128
HIGHEST: Final = 1 << 40
MOST_KEYS: Final = 8


@dataclass(frozen=True, slots=True)
class Hello:
    """First message on every connection, from both sides."""

    version: str
    sender: str
    """Unique name of the sending process."""
    challenge: bytes


@dataclass(frozen=True, slots=True)
class SignedClaim:
    """A claim as received; it counts only once `verified`."""

    term: Term
    number: int
    signature: bytes


@dataclass(frozen=True, slots=True)
class FollowRequest:
    """Request to follow the show from line `number` of that stream, if it is still available."""

    stream: str
    number: int


@dataclass(frozen=True, slots=True)
class StreamStart:
    """Announces that the following lines are of that stream, from `number`; `restart`: from its start."""

    stream: str
    number: int
    restart: bool


@dataclass(frozen=True, slots=True)
class CannotFollow:
    """The sender cannot stand by."""

    why: str


@dataclass(frozen=True, slots=True)
class FollowerState:
    """Regular report of a machine that stands by."""

    tick: int = 0
    """The last one that it has run."""
    compared: int = 0
    different: int = 0
    """Measures whose state was compared with the leader's, and those that differed."""


@dataclass(frozen=True, slots=True)
class ShowKeys:
    """What a machine that stands by has to know to serve the same pages and phones once it leads."""

    keys: tuple[tuple[str, str], ...] = field(repr=False)


@dataclass(frozen=True, slots=True)
class Restart:
    """Order to a machine that stands by: its program starts again."""


Plain = Hello | Pulse | HandOver | FollowRequest | StreamStart | CannotFollow | FollowerState | ShowKeys | Restart
PeerMessage = Plain | SignedClaim


class InvalidMessage(ValueError):
    """A line that is not a valid message."""


def signed_claim(identity: Identity, receiver: Peer, challenge: bytes, number: int, claim: Claim) -> str:
    """Return the line of a claim, valid for `receiver` only."""
    data = _signed_data(challenge, identity.fingerprint, receiver.fingerprint, number, claim.term)
    return _line("claim", **_term(claim.term), number=number, signature=identity.sign(data).hex())


def verified(claim: SignedClaim, sender: Peer, receiver: Identity, challenge: bytes, after: int) -> Claim | None:
    """Return the claim if `sender` signed it for this connection and its number is above `after`, else None."""
    data = _signed_data(challenge, sender.fingerprint, receiver.fingerprint, claim.number, claim.term)
    if claim.number <= after or not sender.verify(claim.signature, data):
        return None
    return Claim(claim.term)


def format_message(message: Plain) -> str:
    """Return a message as a line."""
    match message:
        case Hello():
            return _line("hello", version=message.version, me=message.sender, challenge=message.challenge.hex())
        case Pulse():
            return _line(
                "pulse", **_term(message.term), leads=message.leads, ready=message.ready, deputy=message.deputy,
                other=message.other_deputy, silent=message.silent, idle=message.idle,
            )  # fmt: skip
        case HandOver():
            return _line("hand over", **_term(message.term))
        case FollowRequest():
            return _line("follow", stream=message.stream, number=message.number)
        case StreamStart():
            return _line("show", stream=message.stream, number=message.number, anew=message.restart)
        case CannotFollow():
            return _line("cannot", why=message.why)
        case FollowerState():
            return _line("state", tick=message.tick, compared=message.compared, different=message.different)
        case ShowKeys():
            return _line("keys", keys=dict(message.keys))
        case Restart():
            return _line("restart")


def parse_message(values: dict[str, Any]) -> PeerMessage:
    """Parse a line that begins with `alive`; Senseless if it is not valid."""
    match values.get("alive"):
        case "hello":
            return Hello(_text(values, "version"), _text(values, "me"), _hex(values, "challenge", CHALLENGE))
        case "pulse":
            silent = None if values.get("silent") is None else _seconds(values, "silent")
            flags = (_flag(values, "leads"), _flag(values, "ready"), _flag(values, "deputy"), _flag(values, "other"))
            return Pulse(_term_of(values), *flags, silent=silent, idle=_seconds(values, "idle"))
        case "claim":
            return SignedClaim(_term_of(values), _integer(values, "number"), _hex(values, "signature", 64))
        case "hand over":
            return HandOver(_term_of(values))
        case "follow":
            return FollowRequest(_text(values, "stream"), _integer(values, "number"))
        case "show":
            return StreamStart(_text(values, "stream"), _integer(values, "number"), _flag(values, "anew"))
        case "cannot":
            return CannotFollow(str(values.get("why"))[:1024])
        case "state":
            return FollowerState(*(_integer(values, key) for key in ("tick", "compared", "different")))
        case "keys":
            found = values.get("keys")
            if not isinstance(found, dict) or len(found) > MOST_KEYS:
                raise InvalidMessage
            return ShowKeys(tuple((name, _text(found, name)) for name in found))
        case "restart":
            return Restart()
        case _:
            raise InvalidMessage


def leadership_message(message: PeerMessage) -> Message | None:
    """Return the message if it concerns leadership and needs no signature, else None."""
    return message if isinstance(message, Pulse | HandOver) else None


def read_line(line: str | bytes) -> dict[str, Any]:
    """Return a line's JSON object; empty if it is none."""
    try:
        told = json.loads(line)
    except (ValueError, RecursionError):
        return {}
    return told if isinstance(told, dict) else {}


def _signed_data(challenge: bytes, sender: str, receiver: str, number: int, term: Term) -> bytes:
    return json.dumps([CONTEXT, challenge.hex(), sender, receiver, number, term.epoch, term.leader]).encode()


def _line(name: str, **values: Any) -> str:
    return json.dumps({"alive": name, **values}, separators=(",", ":"))


def _term(term: Term) -> dict[str, Any]:
    return {"epoch": term.epoch, "leader": term.leader}


def _term_of(values: dict[str, Any]) -> Term:
    return Term(_integer(values, "epoch"), _text(values, "leader"))


def _text(values: dict[str, Any], key: str) -> str:
    found = values.get(key)
    if not isinstance(found, str) or len(found) > LONGEST_NAME or not (found.isprintable() and found.isascii()):
        raise InvalidMessage
    return found


def _integer(values: dict[str, Any], key: str) -> int:
    found = values.get(key)
    if not isinstance(found, int) or isinstance(found, bool) or not 0 <= found < HIGHEST:
        raise InvalidMessage
    return found


def _flag(values: dict[str, Any], key: str) -> bool:
    found = values.get(key)
    if not isinstance(found, bool):
        raise InvalidMessage
    return found


def _seconds(values: dict[str, Any], key: str) -> float:
    found = values.get(key)
    if not isinstance(found, int | float) or isinstance(found, bool) or not 0.0 <= found < 1e9 or math.isnan(found):
        raise InvalidMessage
    return float(found)


def _hex(values: dict[str, Any], key: str, length: int) -> bytes:
    found = values.get(key)
    if not isinstance(found, str) or len(found) != 2 * length:
        raise InvalidMessage
    try:
        return bytes.fromhex(found)
    except ValueError:
        raise InvalidMessage from None
