"""OSC server over UDP: one thread that time-stamps datagrams, passes them to an `OscHandler` and sends the answers.

No datagram can stop it: errors are counted, and messages with a time tag ahead wait in a queue instead of blocking the
receiver. A distant sender never gets more bytes than it sent.
"""

import ipaddress
import os
import selectors
import socket
from collections import deque
from collections.abc import Callable, Iterable
from typing import Any, Final

from live.base.event_queue import PriorityQueue
from live.clock.time_source import Clock
from live.control.events.events import ControlEvent
from live.control.osc.osc_codec import MAX_PACKET_BYTES
from live.control.osc.osc_handler import OscHandler
from live.control.osc.osc_prefilter import OscPrefilter
from live.control.osc.osc_socket import bound_socket, dropped_datagrams
from live.control.osc.udp_batch import BATCH_SIZE, DatagramReader
from live.control.registry.control import Role
from live.control.registry.registry import REGISTRY, Changes, Registry
from live.control.registry.rejections import Reason, Rejection, Tally
from live.control.worker_thread import WorkerThread

_PAUSE_S: Final = 0.05
MAX_BATCHES: Final = 4
"""Maximum number of batch reads before other work has its turn."""
FLOOD_SIZE: Final = 16
"""Number of datagrams in one batch that counts as a flood ..."""
FLOOD_WAIT: Final = 0.001
"""... and the wait before the next batch then [s]."""

Network = ipaddress.IPv4Network | ipaddress.IPv6Network


class OscInput:
    """Receives OSC on `host`:`port` (0: any free port) and puts the events into `lane`, stamped by `clock`.

    `allow`: addresses or networks ("192.168.1.0/24") that may send; None: all.
    Its own daemon thread receives; all counters may be read from any thread.
    """

    def __init__(
        self,
        host: str,
        port: int,
        lane: PriorityQueue[ControlEvent],
        clock: Clock,
        *,
        allow: Iterable[str] | None = None,
        registry: Registry = REGISTRY,
        inherited: int | None = None,
        role: Role = "operator",
        option: str = "--osc",
        on_received: Callable[[], float | None] = lambda: None,
        make_lane: Callable[[], PriorityQueue[ControlEvent]] | None = None,
        flood_wait: float = FLOOD_WAIT,
    ) -> None:
        """`inherited`: the descriptor of a socket that another process has bound and keeps; `role`: the permissions at
        this port; `option`: the command line option named in error messages; `on_received`: called after events have
        come, returns the seconds until its next call; `make_lane`: makes a lane for each sender; `flood_wait` [s]: the
        wait between batches in a flood."""
        self._inherited, self._flood_wait = inherited, flood_wait
        self._host, self._wanted_port, self._option = host, port, option
        self._clock, self._lane, self._on_received = clock, lane, on_received
        self._next_call: float | None = None
        self.handler = OscHandler(lane, registry=registry, role=role, make_lane=make_lane)
        self._changed: deque[str] = deque(maxlen=4096)
        self._allow: tuple[Network, ...] | None = None
        if allow is not None:
            self._allow = tuple(ipaddress.ip_network(entry, strict=False) for entry in allow)
        self._socket: socket.socket | None = None
        self._wake: tuple[socket.socket, socket.socket] | None = None
        self._worker = WorkerThread("osc", self._receive, part="the thread that hears OSC")
        self._stopping = self._worker.stopping
        self._prefilter = OscPrefilter(registry, self._handle_datagram, self.handler.rejected)
        self._lost = 0
        self.unsent = 0
        """Number of answers and values that could not be sent."""
        self.received = 0
        """Number of datagrams read from the socket."""

    def start(self) -> None:
        """Bind and start to receive; PortBusy or CannotListen, with the remedy, if that fails."""
        if self._worker.started:
            raise RuntimeError("this OSC input was already started")
        self._socket = (
            bound_socket(self._host, self._wanted_port, self._option)
            if self._inherited is None
            else socket.socket(fileno=os.dup(self._inherited))
        )
        self._wake = socket.socketpair()
        self._worker.start()

    def stop(self) -> None:
        """Stop the thread and free the port; does nothing if it was not started."""
        if self._wake is None or self._socket is None:
            return
        self._wake[1].send(b"\0")
        self._worker.stop(timeout=None)
        self._lost = self.lost
        for one in (self._socket, *self._wake):
            one.close()
        self._socket = self._wake = None

    def __enter__(self) -> "OscInput":
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    @property
    def port(self) -> int:
        """The actual port."""
        return self._wanted_port if self._socket is None else int(self._socket.getsockname()[1])

    @property
    def lost(self) -> int:
        """Number of datagrams dropped by the system because the receive buffer was full (0 if unknown)."""
        return self._lost if self._socket is None else dropped_datagrams(self._socket)

    @property
    def rejected(self) -> Tally:
        """Refused packets and messages by reason."""
        return self.handler.rejected

    @property
    def last_rejection(self) -> Rejection | None:
        """The most recent refusal, for the operator's overlay."""
        return self.handler.last_rejection

    def refused(self) -> dict[str, int]:
        """Return the number of refusals by reason."""
        return self.handler.rejected.as_dict()

    def refusal(self) -> str:
        """Return the last refusal as text: the reason for a packet, the full description for a control."""
        rejection = self.last_rejection
        if rejection is None:
            return ""
        return str(rejection) if rejection.address else f"an OSC packet: {rejection.reason}"

    def status(self) -> dict[str, Any]:
        """Return status figures."""
        door = self.handler
        replaced = self._prefilter.replaced + door.replaced
        return {
            "received": self.received, "lost": self.lost, "replaced": replaced, "waiting": len(door.schedule),
            "waited": door.delayed, "future_timetags": door.future_timetags, "unsent": self.unsent,
            "subscribers": door.subscribers.active, "told": door.subscribers.sent,
        }  # fmt: skip

    def publish(self, changes: Changes) -> None:
        """Publish new values of the show. Call from the show's thread; makes no system call."""
        self.handler.values.update(changes)
        if self.handler.subscribers.active:
            self._changed.extend(changes)

    def _receive(self) -> None:
        assert self._socket is not None
        assert self._wake is not None
        datagrams = DatagramReader(self._socket, MAX_PACKET_BYTES)
        with selectors.DefaultSelector() as selector:
            selector.register(self._socket, selectors.EVENT_READ)
            selector.register(self._wake[0], selectors.EVENT_READ)
            while not self._stopping.is_set():
                ready = selector.select(self._seconds_to_next())
                many = (ready or self._prefilter.has_pending) and self._receive_safely(datagrams)
                self._process_due()
                if many:  # in a flood larger batches are cheaper
                    self._stopping.wait(self._flood_wait)

    def _seconds_to_next(self) -> float | None:
        """Return the seconds until the next timed work; None if there is none."""
        waits = (self.handler.schedule.seconds_to_next(self._clock.now()), self.handler.subscribers.seconds_to_next(),
                 self._next_call, self._flood_wait if self._prefilter.has_pending else None)  # fmt: skip
        return min((wait for wait in waits if wait is not None), default=None)

    def _process_due(self) -> None:
        """Handle delayed messages that are due, and send changed values to subscribers."""
        try:
            now = self._clock.now()
            self.handler.handle_due(now)
            self._next_call = self._on_received()
            if self.handler.subscribers.active:
                moved = {self._changed.popleft(): None for _ in range(len(self._changed))}
                self.handler.subscribers.mark_changed(moved, now)
                self.handler.subscribers.send_due(now, self._send)
        except Exception as error:
            self.handler.reject(Rejection(Reason.INTERNAL, "", f"no {type(error).__name__}: {error}", b""))

    def _receive_safely(self, datagrams: DatagramReader) -> bool:
        """As `_receive_all`; any exception is counted, and receiving goes on."""
        try:
            return self._receive_all(datagrams)
        except Exception as error:
            self.handler.reject(Rejection(Reason.INTERNAL, "", f"no {type(error).__name__}: {error}", b""))
            self._stopping.wait(_PAUSE_S)
            return False

    def _receive_all(self, datagrams: DatagramReader) -> bool:
        """Read the waiting datagrams; return whether they were many and all of them were read."""
        for _ in range(MAX_BATCHES):
            if self._stopping.is_set():
                break
            try:
                found = datagrams.read()
            except OSError:  # network down, or an answer that was undeliverable: keep receiving
                self.rejected.count(Reason.SOCKET)
                self._stopping.wait(_PAUSE_S)
                break
            if not found:
                self._prefilter.process([], self._clock.now())
                break
            now = self._clock.now()
            refused = self._prefilter.process(
                [each for each in found if self._is_allowed(each[1][0])], now, more=len(found) >= FLOOD_SIZE
            )
            if refused is not None:
                self.handler.last_rejection = refused
            self._lane.coalesced = self._prefilter.replaced
            self.received += len(found)  # last, so that readers of this counter see its consequences
            if len(found) < BATCH_SIZE:
                return len(found) >= FLOOD_SIZE
        return False

    def _handle_datagram(self, data: bytes, sender: Any) -> bool:
        """Handle a datagram; return whether nothing in it was refused."""
        before = self.handler.rejected.total
        try:
            for answer in self.handler.handle(memoryview(data), sender, self._clock.now()):
                self._send(answer, sender)
        except Exception as error:  # no datagram may stop the receiver
            self.handler.reject(Rejection(Reason.INTERNAL, "", f"no {type(error).__name__}: {error}", data[:16]))
        return self.handler.rejected.total == before

    def _send(self, datagram: bytes, where: Any) -> None:
        assert self._socket is not None
        try:
            self._socket.sendto(datagram, where)
        except OSError:  # the receiver is gone or the send buffer is full: it can ask again
            self.unsent += 1

    def _is_allowed(self, host: str) -> bool:
        """Whether a host may send; a refusal is counted."""
        if self._allow is None:
            return True
        address = ipaddress.ip_address(host.partition("%")[0])
        if any(address in network for network in self._allow):
            return True
        self.handler.reject(Rejection(Reason.SENDER, "", "a listed address", host))
        return False
