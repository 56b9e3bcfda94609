"""Signatures on the bus: each message is by a machine that this one is paired with.

TLS keeps others out of a leader and lets nobody read or change what is sent. But Zenoh's client trusts public web
certificates besides the pinned ones (and here no host name is checked), so a stranger could pose as a leader towards a
node. Therefore every message carries an Ed25519 signature (RFC 8032) over its key and its bytes, and the pins of `live
pair` decide. A pairing that is removed while the show runs ends this at once.
"""

import contextlib
import time
from collections.abc import Callable
from typing import Any, Final

from live.base.errors import PersonError
from live.nodes.bus import Bus, End, Question, Receive, nothing
from live.supervisor.network.identity import Identity, Pairings, Peer

FINGERPRINT: Final = 32
SIGNATURE: Final = 64
HEAD: Final = FINGERPRINT + SIGNATURE
"""Bytes before the message."""
CONTEXT: Final = b"choreographics-live bus 1\0"
LOOK_EVERY: Final = 1.0
"""Seconds between two checks for changed pairings."""


class SignedQuestion:
    """A question whose answer will be signed."""

    def __init__(self, bus: "SignedBus", key: str, question: Question, data: bytes) -> None:
        self.data, self.arrived = data, question.arrived
        self._bus, self._key, self._question = bus, key, question

    def answer(self, data: bytes) -> None:
        """Send the one answer."""
        self._question.answer(self._bus.sealed(self._key, data))


class SignedBus:
    """A bus that signs what it sends and drops what no paired machine has signed. Thread: any."""

    def __init__(self, bus: Bus, identity: Identity, pairings: Pairings) -> None:
        """PersonError for pairings that cannot be read."""
        self.strangers = 0
        """Messages that were dropped."""
        self._bus, self._identity, self._pairings = bus, identity, pairings
        self._look_at = 0.0
        self._mine = bytes.fromhex(identity.fingerprint)
        self._read()

    def _read(self) -> None:
        self._version = self._pairings.version()
        peers: list[Peer] = [self._identity.as_peer(), *self._pairings.read()]
        self._keys: dict[bytes, Any] = {bytes.fromhex(peer.fingerprint): peer.public_key for peer in peers}

    def refresh(self) -> None:
        """Read the pairings again if they have changed; if they cannot be read, nothing changes."""
        now = time.monotonic()
        if now < self._look_at:
            return
        self._look_at = now + LOOK_EVERY
        if self._pairings.version() != self._version:
            with contextlib.suppress(PersonError, OSError, ValueError):  # the supervisor must not end because of it
                self._read()

    def sealed(self, key: str, data: bytes) -> bytes:
        """Return a message with its signature."""
        return self._mine + self._identity.sign(CONTEXT + key.encode() + b"\0" + data) + data

    def opened(self, key: str, sealed: bytes) -> bytes | None:
        """Return a message without its signature; None if no paired machine has signed it."""
        from cryptography.exceptions import InvalidSignature

        public = self._keys.get(sealed[:FINGERPRINT])
        if public is not None and len(sealed) >= HEAD:
            data = sealed[HEAD:]
            try:
                public.verify(sealed[FINGERPRINT:HEAD], CONTEXT + key.encode() + b"\0" + data)
            except InvalidSignature:
                pass
            else:
                return data
        self.strangers += 1
        return None

    def publish(self, key: str, data: bytes, *, bulk: bool = False) -> None:
        """Sign and send; `bulk`: see `Bus`."""
        self._bus.publish(key, self.sealed(key, data), bulk=bulk)

    def receive(self, key: str, act: Receive) -> None:
        """Call `act` with all that a paired machine publishes under this key."""

        def hear(sealed: bytes) -> None:
            if (data := self.opened(key, sealed)) is not None:
                act(data)

        self._bus.receive(key, hear)

    def serve(self, key: str, act: Callable[[Question], None], *, anyone: bool = False) -> None:
        """Call `act` with each question. `anyone`: of any machine that TLS has let in, signed or not: a question that
        changes nothing, and is asked often."""

        def hear(question: Question) -> None:
            data = question.data[HEAD:] if anyone else self.opened(key, question.data)
            if data is not None:
                act(SignedQuestion(self, key, question, data))

        self._bus.serve(key, hear)

    def ask(
        self, key: str, data: bytes, act: Receive, *, timeout: float, anyone: bool = False, bulk: bool = False,
        end: End = nothing,
    ) -> None:  # fmt: skip
        """Ask; `act` gets each answer that a paired machine has signed. `anyone`: as for `serve`; `bulk`, `end`: see
        `Bus`."""

        def hear(sealed: bytes) -> None:
            if (found := self.opened(key, sealed)) is not None:
                act(found)

        asked = bytes(HEAD) + data if anyone else self.sealed(key, data)
        self._bus.ask(key, asked, hear, timeout=timeout, bulk=bulk, end=end)

    def close(self) -> None:
        """Close the bus."""
        self._bus.close()
