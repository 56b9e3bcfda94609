"""OSC in a process of its own: whatever is sent to the port, the show's Python is busy with none of it.

The process receives, checks and answers; what is to happen comes to the show in packets, two in a tick at most.
The socket belongs to the show, or to its supervisor: while the process is started again, what is sent waits in it.
Where there is a supervisor the process is its own, too (`live.app.processes.osc_reader_main`), and goes on while
engines change; what it has heard waits for the next one.
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
"""A packet is sent no sooner than so long [s] after the last: with the wait for the frame that is less than a frame
and a tick, which an operator's message may take."""
IN_A_PACKET: Final = 32
"""Events in a packet at most, and at least one: as many as there is an `Allowance` for, each sender's in turn."""
GATHER: Final = 0.004
"""Seconds for which the process waits for more in a flood: it wakes up less often beside the frame."""
AT_ONCE: Final = 64
"""Values that are told in one packet."""
SAY_EVERY: Final = 0.25
FEW: Final = 8
"""The show takes up the next packet when not more events than this are left of the last."""
ON_THE_WAY: Final = 4
"""Packets that the show has not taken up yet ..."""
PATIENCE: Final = 0.5
"""... unless it has said nothing for so long [s]."""
SOON: Final = 0.002

register_events()  # both ends have them


class OscRemote:
    """The show's side of it: what an `OscInput` is. Thread: the one that runs the show."""

    def __init__(
        self, host: str, port: int, lane: Lane[ControlEvent], clock: Clock, *, inherited: int | None = None,
        reader: int | None = None,
    ) -> None:  # fmt: skip
        """As `OscInput`. `reader`: the descriptor of a socket to the process, if a supervisor keeps it; then that has
        the inherited socket as well, by the same number."""
        self._host, self._port, self._lane, self._clock, self._inherited = host, port, lane, clock, inherited
        self._reader = reader
        self._socket: socket.socket | None = None
        self._helper: Helper | None = None
        self._all: dict[str, Any] = {}
        self._untold: dict[str, Any] = {}
        self._came = self._taken = 0

    def start(self) -> None:
        """Bind, and begin to receive; PortBusy or CannotListen if that cannot be."""
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
        """End it, and the port is free then; but what a supervisor keeps."""
        if self._helper is not None:
            self._helper.stop()
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    @property
    def port(self) -> int:
        """The port it really receives on."""
        return self._port if self._socket is None else int(self._socket.getsockname()[1])

    @property
    def process(self) -> int | None:
        """The number of the process; None while there is none."""
        return None if self._helper is None else self._helper.process

    @property
    def lost(self) -> int:
        """Datagrams that the system dropped because the receive buffer was full."""
        return 0 if self._socket is None else dropped_by(self._socket)

    def frame(self) -> None:
        """Before each frame: take what has come, and tell what has changed."""
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
            self._lane.put(event, key, after=True)  # the order is that of the other process

    def tell(self, changes: Changes) -> None:
        """These have new values in the show."""
        self._all.update(changes)
        self._untold.update(changes)

    def _anew(self) -> None:
        self._came = self._taken = 0
        self._untold = dict(self._all)

    def refused(self) -> dict[str, int]:
        """What was refused, by reason."""
        found: dict[str, int] = self._said("refused", {})
        return found

    def refusal(self) -> str:
        """The last refusal in words."""
        return str(self._said("refusal", ""))

    def _said(self, name: str, otherwise: Any) -> Any:
        return otherwise if self._helper is None else self._helper.facts().get(name, otherwise)

    def facts(self) -> dict[str, Any]:
        """For the status; a quarter of a second old."""
        facts = {} if self._helper is None else self._helper.facts()
        return {name: value for name, value in facts.items() if name not in ("refused", "refusal")} | {
            "lost": self.lost
        }


class Forward:
    """What has come goes to the show: once in `PACE`, and only as much as it takes up; what waits meanwhile waits in
    its lane, where later values replace it. Thread: the one that receives; `taken` is counted by another."""

    def __init__(
        self, send: Callable[[bytes], object], inbox: Inbox[ControlEvent], now: Callable[[], float]
    ) -> None:  # fmt: skip
        self._send, self._inbox, self._now = send, inbox, now
        self._packet = b""
        self._next = self._sent_at = 0.0
        self._allowance = Allowance()
        self.sent = 0
        """Packets that the show was sent."""
        self.taken = 0
        """Packets that the show has taken up."""

    def turn(self) -> float | None:
        """Send what there is; seconds until there may be something to send again."""
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
        except OSError:  # the show stands still: this waits, too
            return TICK
        self._packet = b""
        self.sent, self._sent_at = self.sent + 1, now
        return PACE if len(self._inbox) else None


class Reader:
    """What the process does. Thread: its main one; the port has its own."""

    def __init__(self, told: Told, udp: int) -> None:
        """`udp`: the descriptor of the socket. Nothing is read from it before the show has said what time it is."""
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
        """An engine says what time it is in the show: the first one, or one that goes on after it."""
        self._clock.origin = plan["origin"]
        self._before = self._forward.sent
        if not self._listens:
            self._listens = True
            self._osc.start()

    def turn(self, *others: socket.socket) -> None:
        """Take up what the show says, wait for it or `others` for a while, and say how things are."""
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
    """Receive until the show has gone."""
    told = Told(int(sys.argv[1]))
    reader = Reader(told, told.plan["udp"])
    reader.obey(told.plan)
    while not told.ended:
        reader.turn()
    os._exit(0)  # the show has gone, and the socket is not ours to close


if __name__ == "__main__":
    main()
