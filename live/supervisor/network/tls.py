"""TLS between machines that are paired: TLS 1.3 (RFC 8446), both sides with certificates that the other one has
pinned.

OpenSSL trusts the pinned certificates and none else, and after the handshake the peer's is looked up by its
fingerprint: before that no byte of a peer's is read as more than TLS. A certificate's time is not looked at here: a
show shall not end because a date has passed. Who takes part is decided by the pin; that it has expired is told to the
person. A process of the same user on the same machine has the same certificate, and that one is pinned, too: so that
there is one way only, and other users of the machine are strangers on loopback as well.
"""

import socket
import ssl
from typing import Final

from live.supervisor.line_channel import Wire
from live.supervisor.network.identity import Identity, Pairings, Peer

NO_CHECK_TIME: Final = 0x200000
"""X509_V_FLAG_NO_CHECK_TIME of OpenSSL, which Python has no name for."""
HANDSHAKE_WITHIN: Final = 5.0
"""Seconds that a handshake may take."""
MOST_AT_ONCE: Final = 4 * 1024 * 1024
"""Bytes that are read of one peer before others have their turn."""


class Trust:
    """Who may take part, as contexts of `ssl`; read anew when a machine was paired or forgotten meanwhile."""

    def __init__(self, identity: Identity, pairings: Pairings) -> None:
        """PersonError for pairings that cannot be read."""
        self._identity, self._pairings = identity, pairings
        self._read()

    def _read(self) -> None:
        self._seen = self._pairings.changed()
        mine = self._identity.as_peer()
        self.peers: dict[str, Peer] = {peer.fingerprint: peer for peer in (mine, *self._pairings.read())}
        """By fingerprint; this machine's own is among them."""
        self._server, self._client = (
            self._context(kind) for kind in (ssl.PROTOCOL_TLS_SERVER, ssl.PROTOCOL_TLS_CLIENT)
        )

    def look(self) -> bool:
        """Whether pairings have changed, and were read anew. What cannot be read leaves everything as it was."""
        if self._pairings.changed() == self._seen:
            return False
        try:
            self._read()
        except (OSError, ssl.SSLError, ValueError, LookupError):
            return False
        return True

    def of(self, sock: ssl.SSLSocket) -> Peer | None:
        """Who is at the other end of a stream; None: nobody who may take part."""
        found = sock.getpeercert(binary_form=True)
        peer = None if found is None else Peer("", found)
        return None if peer is None else self.peers.get(peer.fingerprint)

    def wrap(self, sock: socket.socket, *, server: bool) -> ssl.SSLSocket:
        """Begin TLS on a connected socket, which does not wait from now on."""
        sock.setblocking(False)
        context = self._server if server else self._client
        return context.wrap_socket(sock, server_side=server, do_handshake_on_connect=False)

    def _context(self, kind: int) -> ssl.SSLContext:
        context = tls13(kind)
        context.check_hostname = False
        context.verify_mode = ssl.CERT_REQUIRED
        context.verify_flags |= ssl.VERIFY_X509_PARTIAL_CHAIN | ssl.VerifyFlags(NO_CHECK_TIME)
        context.load_cert_chain(self._identity.path)
        context.load_verify_locations(cadata=b"".join(peer.certificate for peer in self.peers.values()))
        return context


def tls13(kind: int) -> ssl.SSLContext:
    """A context of TLS 1.3 alone, without tickets: every connection shows its certificates."""
    context = ssl.SSLContext(kind)
    context.minimum_version = ssl.TLSVersion.TLSv1_3
    if kind == ssl.PROTOCOL_TLS_SERVER:
        context.num_tickets = 0
    return context


class Handshake:
    """One that is under way; never waits. Thread: one."""

    def __init__(self, sock: ssl.SSLSocket, *, until: float) -> None:
        """`until` [s, monotonic]: it has failed by then."""
        self.socket = sock
        self.why = ""
        """Why it failed."""
        self._until = until

    def done(self, now: float) -> bool | None:
        """Whether it succeeded; None: not yet known."""
        try:
            self.socket.do_handshake()
            return True
        except (ssl.SSLWantReadError, ssl.SSLWantWriteError):
            if now < self._until:
                return None
            self.why = "no answer"
        except ssl.SSLCertVerificationError:
            self.why = "a certificate that is not paired with"
        except (OSError, ValueError) as error:
            self.why = str(getattr(error, "reason", None) or error)
        self.socket.close()
        return False


class SecureWire(Wire):
    """A wire to a peer that may take part."""

    socket: ssl.SSLSocket

    def __init__(self, sock: ssl.SSLSocket, peer: Peer, *, backlog: int, longest: int) -> None:
        """`sock`: its handshake is done."""
        super().__init__(sock, backlog=backlog, longest=longest)
        self.peer = peer
        self.refused = False
        """Whether the other side said that this machine may not take part."""

    def _receive(self, got: int) -> bytes | None:
        if got >= MOST_AT_ONCE:
            return None
        try:
            return self.socket.recv(1 << 14)
        except (ssl.SSLWantReadError, ssl.SSLWantWriteError):
            return None
        except ssl.SSLError as error:
            self.refused = "ALERT" in str(error.reason)
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
