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
from live.supervisor.network.peer_messages import FollowerState
from live.supervisor.network.tls import HANDSHAKE_WITHIN, Handshake, SecureChannel, TrustStore
from live.supervisor.process import ProcessManager

RETRY_INTERVAL: Final = 0.5
"""Seconds between two attempts to connect to a machine."""
ANSWERS_WITHIN: Final = 1.0
"""Seconds after which an attempt to connect is given up; short, so that a broken link is restored soon."""
MAX_LINKS: Final = 8
"""Most links."""
MAX_HANDSHAKES: Final = 8
"""Most incoming handshakes at a time; beyond that the oldest is given up."""
ACCEPT_EVERY: Final = 0.02
"""Seconds between two accepted connections: a flood costs at most 50 handshakes a second."""
BACKLOG: Final = 24 * 1024 * 1024
"""Most bytes waiting to be sent to a machine; one that reads more slowly is dropped and may reconnect."""
MAX_LINE_BYTES: Final = 16 * 1024 * 1024
"""Most bytes of a line from another machine: a snapshot of a large show has a few million."""
LOOK_EVERY: Final = 1.0
"""Seconds between two checks for changed pairings."""


@dataclass(eq=False)
class Link:
    """A connection to a paired machine."""

    name: str
    """Unique name of the link."""
    channel: SecureChannel
    upstream: bool
    """Whether this machine opened the connection."""
    challenge: bytes = field(default_factory=lambda: secrets.token_bytes(32))
    """Challenge that the peer has to sign."""
    peer_challenge: bytes | None = None
    """Challenge that this machine has to sign; None before the peer's hello."""
    peer_name: str = ""
    """Unique name of the peer's process."""
    claims_sent: int = 0
    """Number of the last claim sent to the peer."""
    last_claim: int = 0
    """Number of the last claim received from the peer."""
    follows: bool = False
    state: FollowerState = field(default_factory=FollowerState)
    """The last report of a machine that follows, ..."""
    state_tick: int = 0
    """... and the leader's own tick when it came."""

    @property
    def peer(self) -> Peer:
        """The machine at the other end."""
        return self.channel.peer


class Peers:
    """All links to other machines. Thread: the supervisor's."""

    def __init__(
        self, starter: ProcessManager, identity: Identity, pairings: Pairings, *, listener: socket.socket | None,
        upstream: tuple[str, int] | None, say: Callable[[str], None],
    ) -> None:  # fmt: skip
        """`listener`: socket that listens for other machines; `upstream`: the machine to connect to. PersonError for
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
        self.on_refused: Callable[[], None] = lambda: None
        """Called when the upstream machine refuses the connection: no supervisor runs there."""
        self._starter, self._say = starter, say
        self._trust = TrustStore(identity, pairings)
        self._listener, self._upstream = listener, upstream
        self._handshakes: list[tuple[Handshake, bool]] = []
        self._connector = Connector(*upstream) if upstream is not None else None
        self._accept_at = self._call_at = self._look_at = 0.0
        self._reported: set[str] = set()
        self._count = 0
        if listener is not None:
            listener.setblocking(False)

    def update(self, now: float) -> None:
        """Accept, connect, advance handshakes, send pending data and drop broken links."""
        self._accept(now)
        self._connect(now)
        for handshake, upstream in list(self._handshakes):
            if (done := handshake.advance(now)) is not None:
                self._handshakes.remove((handshake, upstream))
                self._open_link(handshake, upstream) if done else self._reject(handshake.why, upstream)
        for link in list(self.links.values()):
            link.channel.flush()
            if link.channel.ended or link.channel.dropped:
                self.drop(link)
        if now >= self._look_at:
            self._look_at = now + LOOK_EVERY
            self._look_at_dates()
            if self._trust.reload_if_changed():
                for link in [link for link in self.links.values() if link.peer.fingerprint not in self._trust.peers]:
                    self._say(f"{link.peer.name} is not paired any more")
                    self.drop(link)

    def drop(self, link: Link) -> None:
        """Close a link; harmless if it is closed already."""
        self._starter.unregister(link.channel)
        if link.channel.rejected:
            self._say_once(f"{link.peer.name} does not know this machine: pair the two again with live pair")
        link.channel.close()
        if self.links.pop(link.name, None) is not None:
            if link.upstream:
                self._call_at = 0.0  # perhaps only the connection broke: reconnect at once
            self.on_end(link)

    def close(self, drain_s: float = 0.0) -> None:
        """Close all links; waits up to `drain_s` seconds for peers to read the last lines."""
        until = time.monotonic() + drain_s
        for link in self.links.values():
            self._starter.unregister(link.channel)
            link.channel.drain_and_close(max(0.0, until - time.monotonic()))
        for handshake, _ in self._handshakes:
            handshake.socket.close()
        if self._listener is not None:
            self._listener.close()

    def _look_at_dates(self) -> None:
        """Report expired certificates. They stay in use, because they are pinned."""
        today = datetime.datetime.now(datetime.UTC)
        there = [self.identity.as_peer(), *(link.peer for link in self.links.values())]
        found = [peer for peer in there if peer.expires < today]
        self.expired = ", ".join(sorted({peer.name for peer in found}))
        for peer in found:
            self._say_once(
                f"the certificate of {peer.name} expired on {peer.expires:%Y-%m-%d}: the show goes on with it; pair "
                "the machines again when it is over (live pair)"
            )

    def _accept(self, now: float) -> None:
        if self._listener is None or now < self._accept_at:
            return
        self._accept_at = now + ACCEPT_EVERY
        with contextlib.suppress(OSError, ssl.SSLError):
            sock, _ = self._listener.accept()
            if len(self.links) >= MAX_LINKS:
                sock.close()
                return
            self._start_handshake(sock, now, upstream=False)

    def _start_handshake(self, sock: socket.socket, now: float, *, upstream: bool) -> None:
        with contextlib.suppress(OSError):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        waiting = [one for one in self._handshakes if not one[1]]
        if not upstream and len(waiting) >= MAX_HANDSHAKES:
            waiting[0][0].socket.close()
            self._handshakes.remove(waiting[0])
            self.strangers += 1
        secure = self._trust.wrap(sock, server=not upstream)
        self._handshakes.append((Handshake(secure, until=now + HANDSHAKE_WITHIN), upstream))

    def _connect(self, now: float) -> None:
        call = self._connector
        if call is None:
            return
        if call.done:
            sock, refused = call.pop_result()
            if sock is not None:
                with contextlib.suppress(OSError, ssl.SSLError):
                    self._start_handshake(sock, now, upstream=True)
            elif refused:
                self.on_refused()
        reached = any(upstream for _, upstream in self._handshakes) or any(x.upstream for x in self.links.values())
        if not reached and not call.running and now >= self._call_at:
            self._call_at = now + RETRY_INTERVAL
            call.start()

    def _open_link(self, handshake: Handshake, upstream: bool) -> None:
        peer = self._trust.peer_of(handshake.socket)
        if peer is None:
            handshake.socket.close()
            self._reject("its certificate is not paired", upstream)
            return
        self._count += 1
        wire = SecureChannel(handshake.socket, peer, backlog=BACKLOG, longest=MAX_LINE_BYTES)
        link = Link(f"{peer.name} #{self._count}", wire, upstream)
        self.links[link.name] = link
        self._starter.register(wire, lambda line: self._receive(link, line))
        self.on_link(link)

    def _receive(self, link: Link, line: str) -> None:
        if link.name in self.links:
            self.on_line(link, line)

    def _reject(self, why: str, upstream: bool) -> None:
        self.strangers += 1
        if upstream and self._upstream is not None:
            host, port = self._upstream
            remedy = f"live pair {host}" if "paired" in why else "is it a machine that leads?"
            self._say_once(f"the machine at {host}:{port} cannot be followed: {why} ({remedy})")

    def _say_once(self, words: str) -> None:
        if words not in self._reported:
            self._reported.add(words)
            self._say(words)


class Connector:
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

    def pop_result(self) -> tuple[socket.socket | None, bool]:
        """Return the connection, if there is one, and whether the machine refused it. Resets the attempt."""
        self._thread = None
        return self._found, self._refused

    def _run(self) -> None:
        run_once(f"the call of {self._to[0]}", self._connect)  # names may raise any error

    def _connect(self) -> None:
        try:
            self._found = socket.create_connection(self._to, timeout=ANSWERS_WITHIN)
        except ConnectionRefusedError:
            self._refused = True
        except OSError:
            pass
