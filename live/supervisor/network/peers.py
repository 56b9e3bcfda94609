"""Links to other machines: incoming and outgoing connections, handshakes and the check of pairings.

Nothing blocks: a handshake advances a step in each turn of the supervisor, and a thread resolves names and connects.
Unpaired machines are counted and dropped without an answer; the number and duration of handshakes are limited.
"""

import contextlib
import datetime
import secrets
import socket
import ssl
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from live.base.fault_isolation import run_once
from live.supervisor.network.identity import Identity, Pairings, Peer
from live.supervisor.network.tls import HANDSHAKE_WITHIN, Handshake, SecureWire, Trust
from live.supervisor.process import Starter

AGAIN: Final = 0.5
"""Seconds between two attempts to connect to a machine."""
ANSWERS_WITHIN: Final = 1.0
"""Seconds after which an attempt to connect is given up; short, so that a broken link is restored soon."""
MOST: Final = 8
"""Most links."""
KNOCKING: Final = 8
"""Most incoming handshakes at a time; beyond that the oldest is given up."""
ACCEPT_EVERY: Final = 0.02
"""Seconds between two accepted connections: a flood costs at most 50 handshakes a second."""
BACKLOG: Final = 24 * 1024 * 1024
"""Most bytes waiting to be sent to a machine; one that reads more slowly is dropped and may reconnect."""
LONGEST: Final = 16 * 1024 * 1024
"""Most bytes of a line from another machine: a snapshot of a large show has a few million."""
LOOK_EVERY: Final = 1.0
"""Seconds between two checks for changed pairings."""


@dataclass(eq=False)
class Link:
    """A connection to a paired machine."""

    name: str
    """Unique name of the link."""
    wire: SecureWire
    upstream: bool
    """Whether this machine opened the connection."""
    challenge: bytes = field(default_factory=lambda: secrets.token_bytes(32))
    """Challenge that the peer has to sign."""
    theirs: bytes | None = None
    """Challenge that this machine has to sign; None before the peer's hello."""
    me: str = ""
    """Unique name of the peer's process."""
    number: int = 0
    """Number of the last claim sent to the peer."""
    heard: int = 0
    """Number of the last claim received from the peer."""
    takes_show: bool = False

    @property
    def peer(self) -> Peer:
        """The machine at the other end."""
        return self.wire.peer


class Peers:
    """All links to other machines. Thread: the supervisor's."""

    def __init__(
        self, starter: Starter, identity: Identity, pairings: Pairings, *, door: socket.socket | None,
        upstream: tuple[str, int] | None, say: Callable[[str], None],
    ) -> None:  # fmt: skip
        """`door`: socket that listens for other machines; `upstream`: the machine to connect to. PersonError for
        pairings that cannot be read."""
        self.identity = identity
        self.links: dict[str, Link] = {}
        self.strangers = 0
        """Connections that failed the handshake or are not paired."""
        self.expired = ""
        """Machines whose certificates have expired."""
        self.on_link: Callable[[Link], None] = lambda link: None
        self.on_line: Callable[[Link, str], None] = lambda link, line: None
        self.on_end: Callable[[Link], None] = lambda link: None
        self.on_nobody: Callable[[], None] = lambda: None
        """Called when the upstream machine refuses the connection: no supervisor runs there."""
        self._starter, self._say = starter, say
        self._trust = Trust(identity, pairings)
        self._door, self._upstream = door, upstream
        self._handshakes: list[tuple[Handshake, bool]] = []
        self._call = Call(*upstream) if upstream is not None else None
        self._accept_at = self._call_at = self._look_at = 0.0
        self._told: set[str] = set()
        self._count = 0
        if door is not None:
            door.setblocking(False)

    def look(self, now: float) -> None:
        """Accept, connect, advance handshakes, send pending data and drop broken links."""
        self._accept(now)
        self._reach(now)
        for handshake, upstream in list(self._handshakes):
            if (done := handshake.done(now)) is not None:
                self._handshakes.remove((handshake, upstream))
                self._shaken(handshake, upstream) if done else self._stranger(handshake.why, upstream)
        for link in list(self.links.values()):
            link.wire.flush()
            if link.wire.ended or link.wire.dropped:
                self.drop(link)
        if now >= self._look_at:
            self._look_at = now + LOOK_EVERY
            self._look_at_dates()
            if self._trust.look():
                for link in [link for link in self.links.values() if link.peer.fingerprint not in self._trust.peers]:
                    self._say(f"{link.peer.name} is not paired any more")
                    self.drop(link)

    def drop(self, link: Link) -> None:
        """Close a link; harmless if it is closed already."""
        self._starter.forget(link.wire)
        if link.wire.refused:
            self._tell_once(f"{link.peer.name} does not know this machine: pair the two again with live pair")
        link.wire.close()
        if self.links.pop(link.name, None) is not None:
            if link.upstream:
                self._call_at = 0.0  # perhaps only the connection broke: reconnect at once
            self.on_end(link)

    def close(self, parting: float = 0.0) -> None:
        """Close all links; waits up to `parting` seconds for peers to read the last lines."""
        until = time.monotonic() + parting
        for link in self.links.values():
            self._starter.forget(link.wire)
            link.wire.part(max(0.0, until - time.monotonic()))
        for handshake, _ in self._handshakes:
            handshake.socket.close()
        if self._door is not None:
            self._door.close()

    def _look_at_dates(self) -> None:
        """Report expired certificates. They stay in use, because they are pinned."""
        today = datetime.datetime.now(datetime.UTC)
        there = [self.identity.as_peer(), *(link.peer for link in self.links.values())]
        found = [peer for peer in there if peer.expires < today]
        self.expired = ", ".join(sorted({peer.name for peer in found}))
        for peer in found:
            self._tell_once(
                f"the certificate of {peer.name} expired on {peer.expires:%Y-%m-%d}: the show goes on with it; pair "
                "the machines again when it is over (live pair)"
            )

    def _accept(self, now: float) -> None:
        if self._door is None or now < self._accept_at:
            return
        self._accept_at = now + ACCEPT_EVERY
        with contextlib.suppress(OSError, ssl.SSLError):
            sock, _ = self._door.accept()
            if len(self.links) >= MOST:
                sock.close()
                return
            self._shake(sock, now, upstream=False)

    def _shake(self, sock: socket.socket, now: float, *, upstream: bool) -> None:
        with contextlib.suppress(OSError):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        waiting = [one for one in self._handshakes if not one[1]]
        if not upstream and len(waiting) >= KNOCKING:
            waiting[0][0].socket.close()
            self._handshakes.remove(waiting[0])
            self.strangers += 1
        secure = self._trust.wrap(sock, server=not upstream)
        self._handshakes.append((Handshake(secure, until=now + HANDSHAKE_WITHIN), upstream))

    def _reach(self, now: float) -> None:
        call = self._call
        if call is None:
            return
        if call.done:
            sock, refused = call.take()
            if sock is not None:
                with contextlib.suppress(OSError, ssl.SSLError):
                    self._shake(sock, now, upstream=True)
            elif refused:
                self.on_nobody()
        reached = any(upstream for _, upstream in self._handshakes) or any(x.upstream for x in self.links.values())
        if not reached and not call.running and now >= self._call_at:
            self._call_at = now + AGAIN
            call.start()

    def _shaken(self, handshake: Handshake, upstream: bool) -> None:
        peer = self._trust.of(handshake.socket)
        if peer is None:
            handshake.socket.close()
            self._stranger("its certificate is not paired", upstream)
            return
        self._count += 1
        wire = SecureWire(handshake.socket, peer, backlog=BACKLOG, longest=LONGEST)
        link = Link(f"{peer.name} #{self._count}", wire, upstream)
        self.links[link.name] = link
        self._starter.listen(wire, lambda line: self._hear(link, line))
        self.on_link(link)

    def _hear(self, link: Link, line: str) -> None:
        if link.name in self.links:
            self.on_line(link, line)

    def _stranger(self, why: str, upstream: bool) -> None:
        self.strangers += 1
        if upstream and self._upstream is not None:
            host, port = self._upstream
            remedy = f"live pair {host}" if "paired" in why else "is it a machine that leads?"
            self._tell_once(f"the machine at {host}:{port} cannot be followed: {why} ({remedy})")

    def _tell_once(self, words: str) -> None:
        if words not in self._told:
            self._told.add(words)
            self._say(words)


class Call:
    """Connects to an address in its own thread, because resolving its name may take seconds. Thread: one."""

    def __init__(self, host: str, port: int) -> None:
        self._to = host, port
        self._thread: threading.Thread | None = None
        self._found: socket.socket | None = None
        self._refused = False

    @property
    def running(self) -> bool:
        """Whether an attempt is in progress."""
        return self._thread is not None

    @property
    def done(self) -> bool:
        """Whether an attempt has finished and its result is pending."""
        return self._thread is not None and not self._thread.is_alive()

    def start(self) -> None:
        """Start an attempt."""
        self._found, self._refused = None, False
        self._thread = threading.Thread(target=self._run, name="call", daemon=True)
        self._thread.start()

    def take(self) -> tuple[socket.socket | None, bool]:
        """Return the connection, if there is one, and whether the machine refused it. Resets the attempt."""
        self._thread = None
        return self._found, self._refused

    def _run(self) -> None:
        run_once(f"the call of {self._to[0]}", self._reach)  # names may raise any error

    def _reach(self) -> None:
        try:
            self._found = socket.create_connection(self._to, timeout=ANSWERS_WITHIN)
        except ConnectionRefusedError:
            self._refused = True
        except OSError:
            pass
