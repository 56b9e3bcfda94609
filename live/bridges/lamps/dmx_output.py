"""DMX output over sACN (E1.31) or Art-Net at a fixed rate.

Run as a module, it is a helper process (`HelperProcess`). The packages sacn and stupidartnet build the packets.
"""

import gc
import secrets
import select
import socket
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, Protocol

import numpy as np
import numpy.typing as npt

from live.bridges.lamps.dmx_mapping import Channel, DmxMapping
from live.clock.time_source import SystemClock
from live.clock.timeline import Timeline
from live.control.helper_process import HelperChannel

RATE: Final = 40.0
"""Frames per second: close to DMX's maximum of 44."""
STATUS_INTERVAL: Final = 1.0
SACN_PORT: Final = 5568
ARTNET_PORT: Final = 6454
NAME: Final = "ChoreoGraphics Live"


@dataclass(frozen=True, slots=True)
class Universe:
    """Destination of the channel values. With an empty `host`, sACN goes to all receivers of the universe
    (multicast)."""

    protocol: Literal["sacn", "artnet"]
    number: int
    host: str
    port: int


class Sender(Protocol):
    """Sender of 512 channel bytes; raises OSError if the network refuses them."""

    def send(self, row: npt.NDArray[np.uint8]) -> None: ...
    def close(self) -> None: ...


class SacnSender:
    """Sender of a universe over sACN."""

    def __init__(self, to: Universe) -> None:
        from sacn import DataPacket

        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 8)
        group = f"239.255.{to.number >> 8}.{to.number & 255}"
        self._to = (socket.gethostbyname(to.host) if to.host else group, to.port)
        self._packet = DataPacket(tuple(secrets.token_bytes(16)), NAME, to.number, (0,) * 512)

    def send(self, row: npt.NDArray[np.uint8]) -> None:
        """Send one frame of channel values."""
        self._packet.dmxData = tuple(row.tolist())
        self._socket.sendto(bytes(self._packet.getBytes()), self._to)
        self._packet.sequence_increase()

    def close(self) -> None:
        """Send the end of the stream and close."""
        self._packet.option_StreamTerminated = True
        try:
            for _ in range(3):  # E1.31 requires three packets
                self._socket.sendto(bytes(self._packet.getBytes()), self._to)
                self._packet.sequence_increase()
        except OSError:
            pass
        self._socket.close()


class ArtnetSender:
    """Sender of a universe over Art-Net."""

    def __init__(self, to: Universe) -> None:
        from stupidArtnet import StupidArtnet

        self._to = (socket.gethostbyname(to.host), to.port)
        self._sender = StupidArtnet(self._to[0], to.number, 512, RATE, port=to.port)
        self._sender.socket_client.setblocking(False)

    def send(self, row: npt.NDArray[np.uint8]) -> None:
        """Send one frame. The library's own `show` is not used because it hides network errors."""
        self._sender.socket_client.sendto(bytes(self._sender.packet_header) + row.tobytes(), self._to)

    def close(self) -> None:
        """Close the socket."""
        self._sender.close()


def make_sender(universe: Universe) -> Sender:
    """Return a sender for a universe; OSError if there is no network."""
    return SacnSender(universe) if universe.protocol == "sacn" else ArtnetSender(universe)


class DmxOutput:
    """Scheduler of the DMX frames. Thread: one."""

    def __init__(self, chart: DmxMapping, senders: Sequence[Sender]) -> None:
        self._chart, self._senders = chart, senders
        self._timeline: Timeline | None = None
        self.sent = self.failed = 0

    def handle(self, packet: tuple[str, Any], now: float) -> None:
        """Handle a packet from the show: the same kinds as `OscOutput`, `values`, and `channels`."""
        what, value = packet
        if what == "timeline":
            self._timeline = Timeline(*value)
        elif what == "values":
            self._chart.update_values(value)
        elif what == "channels":
            self._chart.channels = tuple(Channel(*each) for each in value)
        elif what == "positions":
            self._chart.update_positions(np.frombuffer(value, np.float32).reshape(-1, 4))
        elif what == "news" and self._timeline is not None:
            beat = self._timeline.beat_at(now)
            for name, values in value:
                if name == "step":
                    self._chart.flash("steps", beat)
                elif name == "foot":
                    self._chart.flash("feet", beat, values[4])

    def send_frame(self, now: float) -> None:
        """Send one frame; frames that the network refuses are counted."""
        if self._timeline is None:
            return
        row = self._chart.row(self._timeline, now)
        for sender in self._senders:
            try:
                sender.send(row)
                self.sent += 1
            except OSError:
                self.failed += 1


def main() -> None:
    """Send until the show ends."""
    told = HelperChannel(sys.argv[1])
    gc.disable()
    plan = told.plan
    senders = [make_sender(Universe(*each)) for each in plan["universes"]]
    out = DmxOutput(DmxMapping([Channel(*each) for each in plan["channels"]], plan["half"]), senders)
    clock = SystemClock(plan["origin"])
    due = say_at = clock.now()
    while not told.closed:
        select.select([told.socket], [], [], max(due - clock.now(), 0.0))
        for packet in told.packets():
            out.handle(packet, clock.now())
        now = clock.now()
        if now < due:
            continue
        due = max(due + 1.0 / RATE, now)
        out.send_frame(now)
        if now >= say_at:
            say_at = now + STATUS_INTERVAL
            gc.collect(0)
            told.send_facts({"rows": out.sent, "failed": out.failed})
    for sender in senders:
        sender.close()


if __name__ == "__main__":
    main()
