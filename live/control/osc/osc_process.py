"""OSC input in a separate process, so that traffic on the port costs the show's interpreter nothing.

The process receives, checks and answers; events reach the show in packets, at most two per tick. The socket belongs to
the show or its supervisor: while the process restarts, datagrams wait in its buffer. Under a supervisor the process
belongs to it, too (`live.app.processes.osc_reader_main`), and keeps running while engines change; events received in
between wait for the next engine.
"""

import os
import select
import socket
import sys
import time
from collections.abc import Callable, Hashable
from typing import Any, Final

from live.base.event_queue import EventQueue, PriorityQueue
from live.base.processing_budget import ProcessingBudget
from live.clock.ticks import TICK
from live.clock.time_source import Clock, SystemClock
from live.control.events.event_json import register_events
from live.control.events.events import ControlEvent
from live.control.helper_process import HelperChannel, HelperProcess
from live.control.message_codec import encode_packet
from live.control.osc.osc_server import OscInput
from live.control.osc.osc_socket import bound_socket, dropped_datagrams
from live.control.registry.registry import Changes

PACKET_INTERVAL: Final = 0.5 * TICK
"""Minimum time between packets [s]. With the wait for the frame, an operator's message takes less than a frame and a
tick."""
MAX_EVENTS: Final = 32
"""Maximum number of events in a packet; the `ProcessingBudget` may lower it to 1. Senders take turns."""
FLOOD_WAIT: Final = 0.004
"""Seconds for which the process waits for more in a flood, so that it wakes up less often next to the frame loop."""
MAX_VALUES: Final = 64
"""Maximum number of values published in one packet."""
STATUS_INTERVAL: Final = 0.25
LOW_WATERMARK: Final = 8
"""The show reads the next packet when no more than so many events are left in its lane."""
MAX_UNCONFIRMED: Final = 4
"""Maximum number of packets that the show has not confirmed ..."""
CONFIRM_TIMEOUT: Final = 0.5
"""... unless none was sent for so long [s]."""
CONFIRM_POLL: Final = 0.002

register_events()  # both ends of the channel encode events


class OscRemote:
    """The show's end of the OSC process, with the interface of `OscInput`. Use from the show's thread."""

    def __init__(
        self, host: str, port: int, lane: PriorityQueue[ControlEvent], clock: Clock, *, inherited: int | None = None,
        reader: int | None = None,
    ) -> None:  # fmt: skip
        """As `OscInput`. `reader`: the descriptor of a socket to a process kept by a supervisor. That process then has
        the inherited socket under the same number."""
        self._host, self._port, self._lane, self._clock, self._inherited = host, port, lane, clock, inherited
        self._reader = reader
        self._socket: socket.socket | None = None
        self._helper: HelperProcess | None = None
        self._all: dict[str, Any] = {}
        self._pending: dict[str, Any] = {}
        self._received = self._confirmed = 0

    def start(self) -> None:
        """Bind and start to receive; PortBusy or CannotListen if that fails."""
        if self._inherited is None:
            self._socket = bound_socket(self._host, self._port)
        else:
            self._socket = socket.socket(fileno=os.dup(self._inherited))
        udp = self._socket.fileno()
        self._helper = HelperProcess(
            "live.control.osc.osc_process", self._clock, {"udp": udp, "nice": 0}, self._on_start, udp,
            on_packet=self._put_events, descriptor=self._reader,
        )  # fmt: skip
        self._helper.start()

    def stop(self) -> None:
        """Stop the process and free the port, except what a supervisor keeps."""
        if self._helper is not None:
            self._helper.stop()
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    @property
    def port(self) -> int:
        """The actual port."""
        return self._port if self._socket is None else int(self._socket.getsockname()[1])

    @property
    def pid(self) -> int | None:
        """The process ID; None if there is no process."""
        return None if self._helper is None else self._helper.pid

    @property
    def lost(self) -> int:
        """Datagrams that the system dropped because the receive buffer was full."""
        return 0 if self._socket is None else dropped_datagrams(self._socket)

    def frame(self) -> None:
        """Receive events and publish changed values; call before each frame."""
        if self._helper is None:
            return
        if len(self._lane) <= LOW_WATERMARK:
            if self._confirmed != self._received and self._helper.send(self._received):
                self._confirmed = self._received
            self._helper.frame(MAX_UNCONFIRMED)
        if self._pending:
            some = {address: self._pending[address] for address in list(self._pending)[:MAX_VALUES]}
            if self._helper.send(some):
                for address in some:
                    del self._pending[address]

    def _put_events(self, events: tuple[tuple[Hashable, ControlEvent], ...]) -> None:
        self._received += 1
        for key, event in events:
            self._lane.put(event, key, ordered=True)  # keeps the other process's order

    def publish(self, changes: Changes) -> None:
        """Queue new values of the show for publication."""
        self._all.update(changes)
        self._pending.update(changes)

    def _on_start(self) -> None:
        self._received = self._confirmed = 0
        self._pending = dict(self._all)

    def refused(self) -> dict[str, int]:
        """Return the number of refusals by reason."""
        found: dict[str, int] = self._fact("refused", {})
        return found

    def refusal(self) -> str:
        """Return the last refusal as text."""
        return str(self._fact("refusal", ""))

    def _fact(self, name: str, otherwise: Any) -> Any:
        return otherwise if self._helper is None else self._helper.status().get(name, otherwise)

    def status(self) -> dict[str, Any]:
        """Return status figures; they are up to `STATUS_INTERVAL` old."""
        facts = {} if self._helper is None else self._helper.status()
        return {name: value for name, value in facts.items() if name not in ("refused", "refusal")} | {
            "lost": self.lost
        }


class EventForwarder:
    """Forwards received events to the show, one packet per `PACKET_INTERVAL` and only as fast as the show confirms
    them.

    Events that wait stay in their lane, where later values replace them. Use from the receiving thread; another thread
    confirms.
    """

    def __init__(
        self, send: Callable[[bytes], object], inbox: EventQueue[ControlEvent], now: Callable[[], float]
    ) -> None:  # fmt: skip
        self._send, self._inbox, self._now = send, inbox, now
        self._packet = b""
        self._next = self._sent_at = 0.0
        self._allowance = ProcessingBudget()
        self.sent = 0
        """Number of packets sent to the show."""
        self.confirmed = 0
        """Number of packets that the show has confirmed."""

    def send_due(self) -> float | None:
        """Send a packet if one is due; return the seconds until the next call, None if nothing waits."""
        now = self._now()
        left = self._allowance.remaining(now, self._inbox.received_count)
        if not self._packet and not len(self._inbox):
            return None
        if now < self._next:
            return self._next - now
        if self.sent - self.confirmed >= MAX_UNCONFIRMED and now - self._sent_at < CONFIRM_TIMEOUT:
            return CONFIRM_POLL
        self._next = now + PACKET_INTERVAL
        if not self._packet:
            events = self._inbox.drain_keyed(min(max(left, 1), MAX_EVENTS), now)
            self._allowance.spend(len(events))
            self._packet = encode_packet(events)
        try:
            self._send(self._packet)
        except OSError:  # the show does not read: keep the packet
            return TICK
        self._packet = b""
        self.sent, self._sent_at = self.sent + 1, now
        return PACKET_INTERVAL if len(self._inbox) else None


class OscReader:
    """Main loop of the process. Runs in its main thread; the port has its own thread."""

    def __init__(self, channel: HelperChannel, udp: int) -> None:
        """`udp`: the descriptor of the socket. Reading starts when the show has sent its clock's origin."""
        self._channel = channel
        self._inbox: EventQueue[ControlEvent] = EventQueue()
        self._clock = SystemClock()
        self._forward = EventForwarder(channel.socket.send, self._inbox, time.perf_counter)
        self._osc = OscInput(
            "", 0, self._inbox.add_queue(), self._clock, inherited=udp, on_received=self._forward.send_due,
            make_lane=self._inbox.add_queue, flood_wait=FLOOD_WAIT,
        )  # fmt: skip
        self._sent_before = 0
        self._started = False
        self._say_at = 0.0

    def apply_plan(self, plan: dict[str, Any]) -> None:
        """Apply the clock of an engine: the first one, or a successor."""
        self._clock.origin = plan["origin"]
        self._sent_before = self._forward.sent
        if not self._started:
            self._started = True
            self._osc.start()

    def process_once(self, *others: socket.socket) -> None:
        """Wait for the show or `others`, handle the show's packets and report the status."""
        select.select([self._channel.socket, *others], [], [], STATUS_INTERVAL)
        for packet in self._channel.packets():
            if isinstance(packet, int):
                self._forward.confirmed = min(self._sent_before + packet, self._forward.sent)
            elif "origin" in packet:
                self.apply_plan(packet)
            else:
                self._osc.publish(packet)
        if not self._started or time.perf_counter() < self._say_at:
            return
        self._say_at = time.perf_counter() + STATUS_INTERVAL
        refused = self._osc.refused()
        if self._inbox.dropped:
            refused["inbox full"] = self._inbox.dropped
        self._channel.send_facts({**self._osc.status(), "refused": refused, "refusal": self._osc.refusal()})


def main() -> None:
    """Receive until the show closes the channel."""
    told = HelperChannel(sys.argv[1])
    reader = OscReader(told, told.plan["udp"])
    reader.apply_plan(told.plan)
    while not told.closed:
        reader.process_once()
    os._exit(0)  # skips clean-up: the socket belongs to the show


if __name__ == "__main__":
    main()
