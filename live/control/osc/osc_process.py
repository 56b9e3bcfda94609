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

from live.base.event_queue import Inbox, Lane
from live.base.processing_budget import Allowance
from live.clock.ticks import TICK
from live.clock.time_source import Clock, SystemClock
from live.control.events.event_json import register_events
from live.control.events.events import ControlEvent
from live.control.helper_process import Helper, Told
from live.control.message_codec import packet_of
from live.control.osc.osc_server import OscInput
from live.control.osc.osc_socket import bound_socket, dropped_by
from live.control.registry.registry import Changes

PACE: Final = 0.5 * TICK
"""Minimum time between packets [s]. With the wait for the frame, an operator's message takes less than a frame and a
tick."""
IN_A_PACKET: Final = 32
"""Maximum number of events in a packet; the `Allowance` may lower it to 1. Senders take turns."""
GATHER: Final = 0.004
"""Seconds for which the process waits for more in a flood, so that it wakes up less often next to the frame loop."""
AT_ONCE: Final = 64
"""Maximum number of values published in one packet."""
SAY_EVERY: Final = 0.25
FEW: Final = 8
"""The show reads the next packet when no more than so many events are left in its lane."""
ON_THE_WAY: Final = 4
"""Maximum number of packets that the show has not confirmed ..."""
PATIENCE: Final = 0.5
"""... unless none was sent for so long [s]."""
SOON: Final = 0.002

register_events()  # both ends of the channel encode events


class OscRemote:
    """The show's end of the OSC process, with the interface of `OscInput`. Use from the show's thread."""

    def __init__(
        self, host: str, port: int, lane: Lane[ControlEvent], clock: Clock, *, inherited: int | None = None,
        reader: int | None = None,
    ) -> None:  # fmt: skip
        """As `OscInput`. `reader`: the descriptor of a socket to a process kept by a supervisor. That process then has
        the inherited socket under the same number."""
        self._host, self._port, self._lane, self._clock, self._inherited = host, port, lane, clock, inherited
        self._reader = reader
        self._socket: socket.socket | None = None
        self._helper: Helper | None = None
        self._all: dict[str, Any] = {}
        self._untold: dict[str, Any] = {}
        self._came = self._taken = 0

    def start(self) -> None:
        """Bind and start to receive; PortBusy or CannotListen if that fails."""
        if self._inherited is None:
            self._socket = bound_socket(self._host, self._port)
        else:
            self._socket = socket.socket(fileno=os.dup(self._inherited))
        udp = self._socket.fileno()
        self._helper = Helper(
            "live.control.osc.osc_process", self._clock, {"udp": udp, "nice": 0}, self._anew, udp, on=self._hear,
            joined=self._reader,
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
    def process(self) -> int | None:
        """The process ID; None if there is no process."""
        return None if self._helper is None else self._helper.process

    @property
    def lost(self) -> int:
        """Datagrams that the system dropped because the receive buffer was full."""
        return 0 if self._socket is None else dropped_by(self._socket)

    def frame(self) -> None:
        """Receive events and publish changed values; call before each frame."""
        if self._helper is None:
            return
        if len(self._lane) <= FEW:
            if self._taken != self._came and self._helper.send(self._came):
                self._taken = self._came
            self._helper.frame(ON_THE_WAY)
        if self._untold:
            some = {address: self._untold[address] for address in list(self._untold)[:AT_ONCE]}
            if self._helper.send(some):
                for address in some:
                    del self._untold[address]

    def _hear(self, events: tuple[tuple[Hashable, ControlEvent], ...]) -> None:
        self._came += 1
        for key, event in events:
            self._lane.put(event, key, after=True)  # keeps the other process's order

    def tell(self, changes: Changes) -> None:
        """Queue new values of the show for publication."""
        self._all.update(changes)
        self._untold.update(changes)

    def _anew(self) -> None:
        self._came = self._taken = 0
        self._untold = dict(self._all)

    def refused(self) -> dict[str, int]:
        """Return the number of refusals by reason."""
        found: dict[str, int] = self._said("refused", {})
        return found

    def refusal(self) -> str:
        """Return the last refusal as text."""
        return str(self._said("refusal", ""))

    def _said(self, name: str, otherwise: Any) -> Any:
        return otherwise if self._helper is None else self._helper.facts().get(name, otherwise)

    def facts(self) -> dict[str, Any]:
        """Return status figures; they are up to `SAY_EVERY` old."""
        facts = {} if self._helper is None else self._helper.facts()
        return {name: value for name, value in facts.items() if name not in ("refused", "refusal")} | {
            "lost": self.lost
        }


class Forward:
    """Forwards received events to the show, one packet per `PACE` and only as fast as the show confirms them.

    Events that wait stay in their lane, where later values replace them. Use from the receiving thread; `taken` is set
    by another thread.
    """

    def __init__(
        self, send: Callable[[bytes], object], inbox: Inbox[ControlEvent], now: Callable[[], float]
    ) -> None:  # fmt: skip
        self._send, self._inbox, self._now = send, inbox, now
        self._packet = b""
        self._next = self._sent_at = 0.0
        self._allowance = Allowance()
        self.sent = 0
        """Number of packets sent to the show."""
        self.taken = 0
        """Number of packets that the show has confirmed."""

    def turn(self) -> float | None:
        """Send a packet if one is due; return the seconds until the next call, None if nothing waits."""
        now = self._now()
        left = self._allowance.left(now, self._inbox.offered)
        if not self._packet and not len(self._inbox):
            return None
        if now < self._next:
            return self._next - now
        if self.sent - self.taken >= ON_THE_WAY and now - self._sent_at < PATIENCE:
            return SOON
        self._next = now + PACE
        if not self._packet:
            events = self._inbox.drain_keyed(min(max(left, 1), IN_A_PACKET), now)
            self._allowance.spend(len(events))
            self._packet = packet_of(events)
        try:
            self._send(self._packet)
        except OSError:  # the show does not read: keep the packet
            return TICK
        self._packet = b""
        self.sent, self._sent_at = self.sent + 1, now
        return PACE if len(self._inbox) else None


class Reader:
    """Main loop of the process. Runs in its main thread; the port has its own thread."""

    def __init__(self, told: Told, udp: int) -> None:
        """`udp`: the descriptor of the socket. Reading starts when the show has sent its clock's origin."""
        self._told = told
        self._inbox: Inbox[ControlEvent] = Inbox()
        self._clock = SystemClock()
        self._forward = Forward(told.socket.send, self._inbox, time.perf_counter)
        self._osc = OscInput(
            "", 0, self._inbox.lane(), self._clock, inherited=udp, after=self._forward.turn, more=self._inbox.lane,
            gather=GATHER,
        )  # fmt: skip
        self._before = 0
        self._listens = False
        self._say_at = 0.0

    def obey(self, plan: dict[str, Any]) -> None:
        """Apply the clock of an engine: the first one, or a successor."""
        self._clock.origin = plan["origin"]
        self._before = self._forward.sent
        if not self._listens:
            self._listens = True
            self._osc.start()

    def turn(self, *others: socket.socket) -> None:
        """Wait for the show or `others`, handle the show's packets and report the status."""
        select.select([self._told.socket, *others], [], [], SAY_EVERY)
        for packet in self._told.packets():
            if isinstance(packet, int):
                self._forward.taken = min(self._before + packet, self._forward.sent)
            elif "origin" in packet:
                self.obey(packet)
            else:
                self._osc.tell(packet)
        if not self._listens or time.perf_counter() < self._say_at:
            return
        self._say_at = time.perf_counter() + SAY_EVERY
        refused = self._osc.refused()
        if self._inbox.dropped:
            refused["inbox full"] = self._inbox.dropped
        self._told.say({**self._osc.facts(), "refused": refused, "refusal": self._osc.refusal()})


def main() -> None:
    """Receive until the show closes the channel."""
    told = Told(int(sys.argv[1]))
    reader = Reader(told, told.plan["udp"])
    reader.obey(told.plan)
    while not told.ended:
        reader.turn()
    os._exit(0)  # skips clean-up: the socket belongs to the show


if __name__ == "__main__":
    main()
