"""Messages between machines other than the show's own lines, as JSON lines that are parsed strictly.

A claim is signed by its sender, over a challenge that the receiver made for this connection and an increasing number.
So a claim made for another machine, for another connection, or earlier is worthless.
"""

import json
import math
from dataclasses import dataclass
from typing import Any, Final

from live.supervisor.network.identity import Identity, Peer
from live.supervisor.network.leadership import Claim, HandOver, Message, Pulse, Term

CONTEXT: Final = "choreographics-live claim 1"
CHALLENGE: Final = 32
"""Bytes."""
LONGEST_NAME: Final = 128
HIGHEST: Final = 1 << 40


@dataclass(frozen=True, slots=True)
class Hello:
    """First message on every connection, from both sides."""

    version: str
    me: str
    """Unique name of the sending process."""
    challenge: bytes


@dataclass(frozen=True, slots=True)
class SignedClaim:
    """A claim as received; it counts only once `verified`."""

    term: Term
    number: int
    signature: bytes


@dataclass(frozen=True, slots=True)
class GiveShow:
    """Request to follow the show from line `number` of that stream, if it is still available."""

    stream: str
    number: int


@dataclass(frozen=True, slots=True)
class ShowComes:
    """Announces that the following lines are of that stream, from `number`; `anew`: from its start."""

    stream: str
    number: int
    anew: bool


@dataclass(frozen=True, slots=True)
class Cannot:
    """The sender cannot stand by."""

    why: str


Said = Hello | Pulse | SignedClaim | HandOver | GiveShow | ShowComes | Cannot


class Senseless(ValueError):
    """A line that is not a valid message."""


def signed_claim(identity: Identity, hearer: Peer, challenge: bytes, number: int, claim: Claim) -> str:
    """Return the line of a claim, valid for `hearer` only."""
    data = _signed_data(challenge, identity.fingerprint, hearer.fingerprint, number, claim.term)
    return _line("claim", **_term(claim.term), number=number, signature=identity.sign(data).hex())


def verified(claim: SignedClaim, sender: Peer, hearer: Identity, challenge: bytes, after: int) -> Claim | None:
    """Return the claim if `sender` signed it for this connection and its number is above `after`, else None."""
    data = _signed_data(challenge, sender.fingerprint, hearer.fingerprint, claim.number, claim.term)
    if claim.number <= after or not sender.signed(claim.signature, data):
        return None
    return Claim(claim.term)


def line_of(message: Hello | Pulse | HandOver | GiveShow | ShowComes | Cannot) -> str:
    """Return a message as a line."""
    match message:
        case Hello():
            return _line("hello", version=message.version, me=message.me, challenge=message.challenge.hex())
        case Pulse():
            return _line(
                "pulse", **_term(message.term), leads=message.leads, ready=message.ready, deputy=message.deputy,
                other=message.other, silent=message.silent, idle=message.idle,
            )  # fmt: skip
        case HandOver():
            return _line("hand over", **_term(message.term))
        case GiveShow():
            return _line("follow", stream=message.stream, number=message.number)
        case ShowComes():
            return _line("show", stream=message.stream, number=message.number, anew=message.anew)
        case Cannot():
            return _line("cannot", why=message.why)


def said(told: dict[str, Any]) -> Said:
    """Parse a line that begins with `alive`; Senseless if it is not valid."""
    match told.get("alive"):
        case "hello":
            return Hello(_text(told, "version"), _text(told, "me"), _hex(told, "challenge", CHALLENGE))
        case "pulse":
            silent = None if told.get("silent") is None else _seconds(told, "silent")
            flags = (_flag(told, "leads"), _flag(told, "ready"), _flag(told, "deputy"), _flag(told, "other"))
            return Pulse(_term_of(told), *flags, silent=silent, idle=_seconds(told, "idle"))
        case "claim":
            return SignedClaim(_term_of(told), _whole(told, "number"), _hex(told, "signature", 64))
        case "hand over":
            return HandOver(_term_of(told))
        case "follow":
            return GiveShow(_text(told, "stream"), _whole(told, "number"))
        case "show":
            return ShowComes(_text(told, "stream"), _whole(told, "number"), _flag(told, "anew"))
        case "cannot":
            return Cannot(str(told.get("why"))[:1024])
        case _:
            raise Senseless


def message_of(told: Said) -> Message | None:
    """Return the message if it concerns leadership and needs no signature, else None."""
    return told if isinstance(told, Pulse | HandOver) else None


def read_line(line: str) -> dict[str, Any]:
    """Return a line's JSON object; empty if it is none."""
    try:
        told = json.loads(line)
    except (ValueError, RecursionError):
        return {}
    return told if isinstance(told, dict) else {}


def _signed_data(challenge: bytes, sender: str, hearer: str, number: int, term: Term) -> bytes:
    return json.dumps([CONTEXT, challenge.hex(), sender, hearer, number, term.epoch, term.leader]).encode()


def _line(name: str, **values: Any) -> str:
    return json.dumps({"alive": name, **values}, separators=(",", ":"))


def _term(term: Term) -> dict[str, Any]:
    return {"epoch": term.epoch, "leader": term.leader}


def _term_of(told: dict[str, Any]) -> Term:
    return Term(_whole(told, "epoch"), _text(told, "leader"))


def _text(told: dict[str, Any], key: str) -> str:
    found = told.get(key)
    if not isinstance(found, str) or len(found) > LONGEST_NAME or not (found.isprintable() and found.isascii()):
        raise Senseless
    return found


def _whole(told: dict[str, Any], key: str) -> int:
    found = told.get(key)
    if not isinstance(found, int) or isinstance(found, bool) or not 0 <= found < HIGHEST:
        raise Senseless
    return found


def _flag(told: dict[str, Any], key: str) -> bool:
    found = told.get(key)
    if not isinstance(found, bool):
        raise Senseless
    return found


def _seconds(told: dict[str, Any], key: str) -> float:
    found = told.get(key)
    if not isinstance(found, int | float) or isinstance(found, bool) or not 0.0 <= found < 1e9 or math.isnan(found):
        raise Senseless
    return float(found)


def _hex(told: dict[str, Any], key: str, length: int) -> bytes:
    found = told.get(key)
    if not isinstance(found, str) or len(found) != 2 * length:
        raise Senseless
    try:
        return bytes.fromhex(found)
    except ValueError:
        raise Senseless from None
