"""OSC over UDP: one socket thread that stamps, decodes, checks and hands events over, and refuses the rest by counting.

Messages act when they arrive: a bundle's time tag is accepted but not waited for (waiting is how one small packet
stops a receiver); time tags in the future are counted. Nothing is ever sent except /dance/pong, to the sender alone,
at most once per datagram and never longer than what was received.
"""

import errno
import ipaddress
import os
import selectors
import socket
import struct
import sys
import threading
import time as _time
from collections.abc import Iterable
from typing import Any, Final

from pythonosc.osc_message_builder import OscMessageBuilder

from live.base.inbox import Inbox
from live.clock.source import Clock
from live.control.control import Reply
from live.control.events import ControlEvent
from live.control.osc_decode import IMMEDIATELY, MAX_PACKET_BYTES, OscRejected, decode
from live.control.registry import REGISTRY, Registry
from live.control.rejections import Reason, Rejection, Tally

RECEIVE_BUFFER_BYTES: Final = 4 * 1024 * 1024
SOURCE: Final = "osc"
_NTP_SECONDS_AT_1970: Final = 2_208_988_800
_SO_MEMINFO: Final = 55  # Linux: nine counters of a socket, the last of which is datagrams dropped before we read them
_MEMINFO = struct.Struct("=9I")
_PAUSE_S: Final = 0.05

Network = ipaddress.IPv4Network | ipaddress.IPv6Network


class CannotListen(Exception):
    """The OSC address cannot be used; the text says why and what to do."""


class PortBusy(CannotListen):
    """Another program (perhaps a second show) already receives on this port."""


class OscInput:
    """Receives OSC on `host`:`port` (0: any free port) and puts the events into `inbox`, stamped by `clock`.

    `allow`: addresses or networks ("192.168.1.0/24") that may send; None: everybody who can reach the socket.
    Thread: its own daemon thread receives; all counters may be read from any thread.
    """

    def __init__(
        self,
        host: str,
        port: int,
        inbox: Inbox[ControlEvent],
        clock: Clock,
        *,
        allow: Iterable[str] | None = None,
        registry: Registry = REGISTRY,
        inherited: int | None = None,
    ) -> None:
        """`inherited`: the descriptor of a socket that was bound by another process, and outlives this one."""
        self._inherited = inherited
        self._host, self._wanted_port = host, port
        self._inbox, self._clock, self._registry = inbox, clock, registry
        self._allow: tuple[Network, ...] | None = None
        if allow is not None:
            self._allow = tuple(ipaddress.ip_network(entry, strict=False) for entry in allow)
        self._socket: socket.socket | None = None
        self._wake: tuple[socket.socket, socket.socket] | None = None
        self._thread: threading.Thread | None = None
        self._stopping = threading.Event()
        self._buffer = bytearray(MAX_PACKET_BYTES + 1)  # one more byte, so that a longer datagram shows
        self._lost = 0
        self.received = 0
        """Datagrams read from the socket."""
        self.accepted = 0
        """Messages that became an event or a reply."""
        self.rejected = Tally()
        """Refused packets and messages by reason."""
        self.future_timetags = 0
        """Messages that asked to act later, and acted at once."""
        self.last_rejection: Rejection | None = None
        """The most recent refusal, for the operator's overlay."""

    def start(self) -> None:
        """Bind and begin to receive; PortBusy or CannotListen, with the remedy, if that cannot be."""
        if self._thread is not None:
            raise RuntimeError("this OSC input was already started")
        self._socket = (
            bound_socket(self._host, self._wanted_port)
            if self._inherited is None
            else socket.socket(fileno=os.dup(self._inherited))
        )
        self._wake = socket.socketpair()
        self._stopping.clear()
        self._thread = threading.Thread(target=self._run, name="osc", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the thread and free the port; harmless if it never started."""
        if self._thread is None or self._wake is None or self._socket is None:
            return
        self._stopping.set()
        self._wake[1].send(b"\0")
        self._thread.join()
        self._lost = self.lost
        for one in (self._socket, *self._wake):
            one.close()
        self._socket = self._wake = self._thread = None

    def __enter__(self) -> "OscInput":
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    @property
    def port(self) -> int:
        """The port it really receives on."""
        return self._wanted_port if self._socket is None else int(self._socket.getsockname()[1])

    @property
    def buffer_bytes(self) -> int:
        """The receive buffer that the system granted (Linux reports twice what it was asked for)."""
        return 0 if self._socket is None else self._socket.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)

    @property
    def lost(self) -> int:
        """Datagrams that the system dropped because the receive buffer was full (0 where it does not say)."""
        if self._socket is None or sys.platform != "linux":
            return self._lost
        try:
            answer = self._socket.getsockopt(socket.SOL_SOCKET, _SO_MEMINFO, _MEMINFO.size)
            return int(_MEMINFO.unpack(answer)[8])
        except (OSError, struct.error):
            return 0

    def _run(self) -> None:
        assert self._socket is not None
        assert self._wake is not None
        with selectors.DefaultSelector() as selector:
            selector.register(self._socket, selectors.EVENT_READ)
            selector.register(self._wake[0], selectors.EVENT_READ)
            while not self._stopping.is_set():
                selector.select()
                self._receive_all(self._socket)

    def _receive_all(self, sock: socket.socket) -> None:
        """Read datagrams until none is left."""
        view = memoryview(self._buffer)
        while not self._stopping.is_set():
            try:
                size, sender = sock.recvfrom_into(self._buffer)
            except BlockingIOError:
                return
            except OSError:  # a network that went away, an answer nobody wanted: the show goes on
                self.rejected.count(Reason.SOCKET)
                self._stopping.wait(_PAUSE_S)
                return
            try:
                self._take(sock, view[:size], sender)
            except Exception as error:  # whatever a datagram may bring to light, the next one is heard
                self._reject(Rejection(Reason.INTERNAL, "", f"no {type(error).__name__}: {error}", bytes(view[:16])))
            self.received += 1  # last, so that whoever sees it sees what became of the datagram

    def _take(self, sock: socket.socket, packet: memoryview, sender: Any) -> None:
        time = self._clock.now()
        if self._allow is not None and not self._allowed(sender[0]):
            self._reject(Rejection(Reason.SENDER, "", "a listed address", sender[0]))
            return
        try:
            messages = decode(packet)
        except OscRejected as rejected:
            self._reject(Rejection(rejected.reason, "", "an OSC packet", bytes(packet[:16])))
            return
        replied = False
        for message in messages:
            if message.timetag != IMMEDIATELY and _lies_ahead(message.timetag):
                self.future_timetags += 1
            result = self._registry.call(message.address, message.arguments, time, SOURCE)
            if isinstance(result, Rejection):
                self._reject(result)
                continue
            self.accepted += 1
            if isinstance(result, ControlEvent):
                self._inbox.put(result)
            elif isinstance(result, Reply) and not replied:
                replied = True
                _reply(sock, result, len(packet), sender)

    def _allowed(self, host: str) -> bool:
        address = ipaddress.ip_address(host.partition("%")[0])
        return any(address in network for network in self._allow or ())

    def _reject(self, rejection: Rejection) -> None:
        self.rejected.count(rejection.reason)
        self.last_rejection = rejection


def bound_socket(host: str, port: int) -> socket.socket:
    """A UDP socket that does not block, with the largest buffer the system grants up to 4 MB; else CannotListen."""
    where = f"{host}:{port}"
    remedy = "choose another with --osc HOST:PORT"
    if not 0 <= port <= 65_535:  # the system would take it modulo 65,536
        raise CannotListen(f"OSC cannot listen on {where}: a port is 1 to 65535; {remedy}")
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
    except (OSError, UnicodeError) as error:
        raise CannotListen(f"OSC cannot listen on {where}: no such address ({error}); {remedy}") from None
    sock = socket.socket(family, kind, protocol)
    try:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
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


def _lies_ahead(timetag: int) -> bool:
    """Whether an NTP time tag is later than now, also across the end of the NTP era in 2036."""
    now = int((_time.time() + _NTP_SECONDS_AT_1970) * 2.0**32)
    return 0 < (timetag - now) % 2**64 < 2**63


def _reply(sock: socket.socket, reply: Reply, received_bytes: int, sender: Any) -> None:
    """Answer the sender, but never with more than was received: a forged sender must gain nothing."""
    datagram = OscMessageBuilder(reply.address).build().dgram
    if len(datagram) <= received_bytes:
        try:
            sock.sendto(datagram, sender)
        except OSError:  # the sender is gone, or the send buffer is full: it may ask again
            return
