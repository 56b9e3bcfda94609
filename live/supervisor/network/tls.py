"""TLS 1.3 (RFC 8446) between paired machines, with pinned certificates on both sides.

OpenSSL trusts only the pinned certificates. After the handshake the peer's certificate is looked up by its fingerprint;
before that nothing but TLS is parsed. Expiry is not checked here, because a show must not end on a date: the pin
decides, and the person is told about expired certificates. A process of the same user on the same machine has the same
certificate, which is pinned, too. So there is one mechanism for all, and other users of the machine have no access over
loopback.
"""

import socket
import ssl
from typing import Final

from live.control.tls import pinned_context
from live.supervisor.line_channel import LineChannel
from live.supervisor.network.identity import Identity, Pairings, Peer

HANDSHAKE_WITHIN: Final = 5.0
"""Seconds allowed for a handshake."""
MOST_AT_ONCE: Final = 4 * 1024 * 1024
"""Bytes read from one peer before others are served."""


class TrustStore:
    """Paired machines, as contexts of `ssl`; reloaded when a pairing is added or removed."""

    def __init__(self, identity: Identity, pairings: Pairings) -> None:
        """PersonError for pairings that cannot be read."""
        self._identity, self._pairings = identity, pairings
        self._read()

    def _read(self) -> None:
        self._version = self._pairings.version()
        mine = self._identity.as_peer()
        self.peers: dict[str, Peer] = {peer.fingerprint: peer for peer in (mine, *self._pairings.read())}
        """Peers by fingerprint, this machine included."""
        self._server, self._client = (
            self._context(kind) for kind in (ssl.PROTOCOL_TLS_SERVER, ssl.PROTOCOL_TLS_CLIENT)
        )

    def reload_if_changed(self) -> bool:
        """Reload the pairings if they have changed; return whether they were reloaded. If they cannot be read, nothing
        changes."""
        if self._pairings.version() == self._version:
            return False
        try:
            self._read()
        except (OSError, ssl.SSLError, ValueError, LookupError):
            return False
        return True

    def peer_of(self, sock: ssl.SSLSocket) -> Peer | None:
        """Return the peer at the other end of a stream; None if it is not paired."""
        found = sock.getpeercert(binary_form=True)
        peer = None if found is None else Peer("", found)
        return None if peer is None else self.peers.get(peer.fingerprint)

    def wrap(self, sock: socket.socket, *, server: bool) -> ssl.SSLSocket:
        """Start TLS on a connected socket and make it non-blocking."""
        sock.setblocking(False)
        context = self._server if server else self._client
        return context.wrap_socket(sock, server_side=server, do_handshake_on_connect=False)

    def _context(self, kind: int) -> ssl.SSLContext:
        return pinned_context(kind, self._identity.path, [peer.certificate for peer in self.peers.values()])


class Handshake:
    """TLS handshake in progress; never blocks. Thread: one."""

    def __init__(self, sock: ssl.SSLSocket, *, until: float) -> None:
        """`until` [s, monotonic]: deadline."""
        self.socket = sock
        self.why = ""
        """Why it failed."""
        self._until = until

    def advance(self, now: float) -> bool | None:
        """Continue; return whether it succeeded, or None while it is in progress."""
        try:
            self.socket.do_handshake()
            return True
        except (ssl.SSLWantReadError, ssl.SSLWantWriteError):
            if now < self._until:
                return None
            self.why = "no answer"
        except ssl.SSLCertVerificationError:
            self.why = "its certificate is not paired"
        except (OSError, ValueError) as error:
            self.why = str(getattr(error, "reason", None) or error)
        self.socket.close()
        return False


class SecureChannel(LineChannel):
    """Line channel to a paired peer."""

    socket: ssl.SSLSocket

    def __init__(self, sock: ssl.SSLSocket, peer: Peer, *, backlog: int, longest: int) -> None:
        """`sock`: a TLS socket after its handshake."""
        super().__init__(sock, backlog=backlog, longest=longest)
        self.peer = peer
        self.rejected = False
        """Whether the other side rejected this machine."""

    def _receive(self, got: int) -> bytes | None:
        if got >= MOST_AT_ONCE:
            return None
        try:
            return self.socket.recv(1 << 14)
        except (ssl.SSLWantReadError, ssl.SSLWantWriteError):
            return None
        except ssl.SSLError as error:
            self.rejected = "ALERT" in str(error.reason)
            return b""
        except OSError:
            return b""

    def _send(self, data: bytes) -> int:
        try:
            return self.socket.send(data)
        except (ssl.SSLWantReadError, ssl.SSLWantWriteError):
            return 0
        except OSError:
            self.ended = True
            return 0
