"""A gateway's way to the show: directly, where it is the only one."""

import asyncio
from collections.abc import Callable
from typing import Any, Protocol

from live.control.audience.aggregator import Aggregator
from live.control.audience.join_tickets import JoinTickets
from live.control.audience.voice_report import VoiceReport
from live.control.helper_process import HelperChannel
from live.control.message_codec import encode_packet


class Uplink(Protocol):
    """What a gateway tells, and who tells it about the show."""

    def start(self, handle: Callable[[Any], None], end: Callable[[], None]) -> None:
        """Call `handle` with each packet of the show, and `end` when it has ended."""

    def publish(self, report: VoiceReport, now: float) -> tuple[int, ...]:
        """Tell what the phones say; return the tally that phones are told."""

    def report_facts(self, facts: dict[str, Any], now: float) -> None:
        """Tell the figures of the status."""


class ShowUplink:
    """Events, the code of the moment and figures, to the show's end of a channel. Thread: the loop's."""

    def __init__(self, channel: HelperChannel, plan: dict[str, Any]) -> None:
        self._channel, self._aggregator = channel, Aggregator()
        self._tickets, self._link = (
            JoinTickets(bytes(plan["secret"]), float(plan.get("code_s", 30.0)), 0.0, 1),
            str(plan["link"]),
        )
        self._key = ""

    def start(self, handle: Callable[[Any], None], end: Callable[[], None]) -> None:
        """Receive the show's packets."""

        def receive() -> None:
            for packet in self._channel.packets():
                handle(packet)
            if self._channel.closed:
                asyncio.get_running_loop().remove_reader(self._channel.socket)
                end()

        asyncio.get_running_loop().add_reader(self._channel.socket, receive)
        receive()

    def publish(self, report: VoiceReport, now: float) -> tuple[int, ...]:
        """Send the event of this tick, if there is one."""
        event = self._aggregator.update(now, report)
        if event is not None and not self._send(event):
            self._aggregator.resend()
        return report.tally

    def report_facts(self, facts: dict[str, Any], now: float) -> None:
        """Send figures, and the code whenever it changes."""
        fresh = self._tickets.key(now)
        if fresh != self._key:
            link = f"{self._link}/#{fresh}"
            self._key = fresh if self._send(("code", link, qr_rows(link))) else ""
        self._channel.send_facts(facts)

    def _send(self, packet: tuple[Any, ...]) -> bool:
        """Send a packet to the show; return whether that was possible. The show may be blocked or gone."""
        try:
            self._channel.socket.send(encode_packet(packet))
        except OSError:
            return False
        return True


def qr_rows(link: str) -> list[str]:
    """Return the QR code of a link as rows of 0 and 1 without margin; empty if the library is missing."""
    try:
        import segno
    except ImportError:
        return []
    return ["".join("1" if dark else "0" for dark in row) for row in segno.make(link, error="m", micro=False).matrix]
