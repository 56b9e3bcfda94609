"""Rate-limited UDP receiver of a motion capture system, with one thread for all its ports."""

import selectors
import socket
from typing import Any, Final

from live.clock.time_source import Clock
from live.control.osc.osc_socket import dropped_datagrams
from live.control.osc.udp_batch import DatagramReader
from live.control.registry.rejections import Reason, Tally
from live.control.worker_thread import WorkerThread

MAX_PER_WINDOW: Final = 2000
"""Maximum datagrams read …"""
WINDOW: Final = 0.1
"""… in a window of this length [s]; further ones are dropped."""
_PAUSE_S: Final = 0.05


class CaptureInput:
    """Receives datagrams and passes them to `handle`. Subclasses implement `open` and `handle`.

    Thread: its own daemon thread receives; all counters may be read from any thread.
    """

    def __init__(self, name: str, clock: Clock, largest: int) -> None:
        """Configure the input; nothing is opened yet. `name`: the thread's; `largest`: maximum bytes of a datagram."""
        self.clock, self._largest = clock, largest
        self.rejected = Tally()
        """Refused datagrams by reason."""
        self.received = 0
        """Datagrams read."""
        self._sockets: list[socket.socket] = []
        self._wake: tuple[socket.socket, socket.socket] | None = None
        self._worker = WorkerThread(name, self._receive_all, part=f"the thread that hears {name}")
        self._stopping = self._worker.stopping
        self._window, self._read = 0.0, 0
        self._lost = 0

    def open(self) -> list[socket.socket]:
        """Return the sockets to receive from; CannotListen, with the remedy, if that fails."""
        raise NotImplementedError

    def handle(self, data: bytes, sender: Any, port: int, now: float) -> None:
        """Handle a datagram of `sender` received on `port` at `now` [s]. Thread: the input's own."""
        raise NotImplementedError

    def start(self) -> None:
        """Bind all ports and start receiving; CannotListen, with the remedy, if that fails."""
        self._sockets = self.open()
        self._wake = socket.socketpair()
        self._worker.start()

    def stop(self) -> None:
        """Stop the thread and free the ports; harmless if it never started."""
        if self._wake is not None:
            self._wake[1].send(b"\0")
            self._worker.stop(timeout=None)
            for one in self._wake:
                one.close()
        self._wake = None
        self._lost = self.lost
        for one in self._sockets:
            one.close()
        self._sockets.clear()

    @property
    def ports(self) -> list[int]:
        """The ports actually in use."""
        return [int(each.getsockname()[1]) for each in self._sockets]

    @property
    def lost(self) -> int:
        """Datagrams that the system dropped because they were not read in time."""
        return self._lost if not self._sockets else sum(dropped_datagrams(each) for each in self._sockets)

    def _receive_all(self) -> None:
        assert self._wake is not None
        with selectors.DefaultSelector() as selector:
            for each in self._sockets:
                port = int(each.getsockname()[1])
                selector.register(each, selectors.EVENT_READ, (DatagramReader(each, self._largest), port))
            selector.register(self._wake[0], selectors.EVENT_READ)
            while not self._stopping.is_set():
                for key, _ in selector.select():
                    if key.data is not None:
                        self.receive(*key.data)

    def receive(self, datagrams: DatagramReader, port: int) -> None:
        """Read the available datagrams within the limits."""
        try:
            found = datagrams.read()
        except OSError:  # the network is gone; the show continues
            self.rejected.count(Reason.SOCKET)
            self._stopping.wait(_PAUSE_S)
            return
        now = self.clock.now()
        if now - self._window >= WINDOW:
            self._window, self._read = now, 0
        for data, sender in found:
            self._read += 1
            if self._read > MAX_PER_WINDOW:
                self.rejected.count(Reason.FLOOD)
                continue
            try:
                self.handle(data, sender, port, now)
            except Exception:  # no datagram may prevent the next one from being handled
                self.rejected.count(Reason.INTERNAL)
        self.received += len(found)  # last, so that the other counters are complete when a reader sees it
        if self._read > MAX_PER_WINDOW:
            self._stopping.wait(max(self._window + WINDOW - now, 0.001))

    def status(self) -> dict[str, Any]:
        """Return facts for the status."""
        return {"received": self.received, "lost": self.lost, "refused": self.rejected.as_dict()}
