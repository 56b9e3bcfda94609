"""VMC over UDP: what real dancers do goes into the show's inbox, whoever sends from wherever."""

import socket
from contextlib import ExitStack
from typing import Any, Final

from live.base.lane import Lane
from live.clock.time_source import Clock
from live.control.capture.mocap_seats import GONE_AFTER, Seat, Seats
from live.control.capture.udp_input import CaptureInput
from live.control.capture.vmc_decode import MAX_PACKET_BYTES
from live.control.capture.vmc_stream import VmcStream
from live.control.events.events import ControlEvent
from live.control.osc.osc_socket import bound_socket
from live.control.registry.rejections import Reason

MOST_STREAMS: Final = 64


class VmcInput(CaptureInput):
    """Receives VMC on each of `endpoints` and puts the performers' poses into `lane`."""

    def __init__(
        self, endpoints: tuple[tuple[str, int], ...], seats: tuple[Seat, ...], lane: Lane[ControlEvent], clock: Clock
    ) -> None:
        """Nothing is opened yet. `seats`: the performers there may be."""
        super().__init__("vmc", clock, MAX_PACKET_BYTES)
        self._endpoints, self._lane = endpoints, lane
        self._seats = Seats(seats)
        self._wanted: tuple[Seat, ...] | None = None
        self._streams: dict[tuple[int, Any], VmcStream] = {}

    def open(self) -> list[socket.socket]:
        """See `CaptureInput`."""
        with ExitStack() as opened:
            sockets = [opened.enter_context(bound_socket(host, port, "--vmc")) for host, port in self._endpoints]
            opened.pop_all()
        return sockets

    def reseat(self, seats: tuple[Seat, ...]) -> None:
        """These are the performers from now on. Thread: any."""
        self._wanted = seats

    def hear(self, data: bytes, sender: Any, port: int, now: float) -> None:
        """See `CaptureInput`."""
        if self._wanted is not None:
            self._seats, self._wanted = Seats(self._wanted), None
        who = (port, sender)
        stream = self._streams.get(who)
        if stream is None:
            if len(self._streams) >= MOST_STREAMS and not self._make_room(now):
                self.rejected.count(Reason.SENDER)
                return
            stream = self._streams[who] = VmcStream(
                lambda time: self._seats.find(who, port, sender[0], time), self.rejected, self._lane.put
            )
        stream.hear(data, now)

    def _make_room(self, now: float) -> bool:
        """Forget senders of whom no pose has come for long; whether there were any."""
        gone = [who for who, stream in self._streams.items() if now - stream.last > GONE_AFTER]
        for who in gone:
            del self._streams[who]
        return bool(gone)

    def facts(self) -> dict[str, Any]:
        """For the status."""
        now = self.clock.now()
        streams = {
            stream.performer: {"from": f"{who[1][0]}:{who[1][1]}", **stream.facts(now)}
            for who, stream in tuple(self._streams.items())
            if stream.performer
        }
        return {**super().facts(), "performers": streams}
