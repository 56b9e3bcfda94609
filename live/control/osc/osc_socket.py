"""The UDP socket for OSC input, and the errors raised if it cannot be opened."""

import contextlib
import errno
import socket
import struct
from typing import Final

from live.base.system.features import LINUX

RECEIVE_BUFFER_BYTES: Final = 4 * 1024 * 1024
_SO_RCVBUFFORCE: Final = 33
_SO_MEMINFO: Final = 55  # Linux: nine counters of a socket; the last is the number of dropped datagrams
_MEMINFO = struct.Struct("=9I")


class CannotListen(Exception):
    """The OSC address cannot be used; the message gives reason and remedy."""


class PortBusy(CannotListen):
    """Another program (perhaps a second show) already receives on this port."""


def bound_socket(host: str, port: int, option: str = "--osc") -> socket.socket:
    """Return a non-blocking UDP socket with the largest buffer the system grants up to 4 MB; else CannotListen."""
    where = f"{host}:{port}"
    remedy = f"choose another with {option} HOST:PORT"
    if not 0 <= port <= 65_535:  # the system would take it modulo 65,536
        raise CannotListen(f"OSC cannot listen on {where}: a port is 1 to 65535; {remedy}")
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
    except (OSError, UnicodeError) as error:
        raise CannotListen(f"OSC cannot listen on {where}: no such address ({error}); {remedy}") from None
    sock = socket.socket(family, kind, protocol)
    try:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
        if LINUX:  # beyond the usual limit, if permitted
            with contextlib.suppress(OSError):
                sock.setsockopt(socket.SOL_SOCKET, _SO_RCVBUFFORCE, RECEIVE_BUFFER_BYTES)
        sock.setblocking(False)
        sock.bind(address)
    except OSError as error:
        sock.close()
        if error.errno == errno.EADDRINUSE:
            raise PortBusy(
                f"OSC cannot listen on {where}: another program already uses this port; stop it, or {remedy}"
            ) from None
        raise CannotListen(f"OSC cannot listen on {where}: {error}; {remedy}") from None
    return sock


def dropped_datagrams(sock: socket.socket) -> int:
    """Return the number of datagrams dropped by the system because the receive buffer was full (0 if unknown)."""
    if not LINUX:
        return 0
    try:
        answer = sock.getsockopt(socket.SOL_SOCKET, _SO_MEMINFO, _MEMINFO.size)
        return int(_MEMINFO.unpack(answer)[8])
    except (OSError, struct.error):
        return 0
