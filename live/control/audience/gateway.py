"""Gateway process: serves the audience's phones and sends their aggregated input to the show.

It reads no files of a show, stores no personal data and writes nothing to disk. Phones cannot send free text: see
`phone_protocol`. The listening socket belongs to the show, so phones that join during a restart wait in its backlog.
"""

import asyncio
import contextlib
import gc
import logging
import socket
import sys
from collections.abc import Callable
from typing import Any, Final

import numpy as np
from aiohttp import web

from live.base.system.process_control import raise_open_files
from live.clock.ticks import TICK
from live.control.audience.aggregator import Aggregator
from live.control.audience.broadcaster import Broadcaster
from live.control.audience.http_server import HELLO_TIMEOUT, HttpServer
from live.control.audience.session_state import BeatClock, Rules, SessionState
from live.control.audience.tls import server_context
from live.control.helper_process import HelperChannel
from live.control.message_codec import encode_packet
from live.control.web.task_guard import guarded, keep_task

STATUS_INTERVAL: Final = 0.5
RULES_TIMEOUT: Final = 1.0
"""Time to wait for the show's rules [s] before phones are accepted."""
FULL_COLLECTION_INTERVAL: Final = 60.0
MAX_TICKS: Final = 1024
"""Number of ticks whose lateness is recorded: 16 s."""
FILES: Final = 1024
"""Additional file descriptors besides one per phone."""
TLS_SHUTDOWN_TIMEOUT: Final = 2.0
"""Time-out of the TLS shutdown [s]."""


class Gateway:
    """Gateway of one show. Thread: the loop's."""

    def __init__(self, channel: HelperChannel, plan: dict[str, Any]) -> None:
        self._channel, self._secret, self._link = channel, bytes(plan["secret"]), str(plan["link"])
        self._certificate: tuple[bytes, bytes] | None = plan.get("certificate")
        self.session, self._aggregator = SessionState(plan), Aggregator()
        self._broadcaster = Broadcaster(self.session)
        self.session.gather = self.gather
        self._server = HttpServer(self.session, self._broadcaster, self._secret, plan)
        self._ended = asyncio.Event()
        self._has_rules = asyncio.Event()
        self._lateness_samples = np.zeros(MAX_TICKS)
        self._tick = 0
        self._tidied = self.session.now()

    def receive(self) -> None:
        """Handle packets from the show."""
        for packet in self._channel.packets():
            self.session.heard_show_at = self.session.now()
            if isinstance(packet, Rules):
                self.session.update_rules(packet)
                self._broadcaster.update_rules(packet)
                self._has_rules.set()
                self.gather()  # the operator's change applies at once, not a tick later
            elif isinstance(packet, BeatClock):
                self.session.beat = packet
                self._broadcaster.update_beat(packet)
            elif isinstance(packet, tuple) and packet[0] == "stage":
                self._broadcaster.update_stage(packet[1], packet[2])
        if self._channel.closed:
            self._ended.set()
            self._has_rules.set()

    def gather(self) -> None:
        """Send the aggregate to the show: once per tick, and at once after a command of the operator.

        A message that is handled when a tick is due also calls this, because timers are late under load.
        """
        now = self.session.now()
        self._lateness_samples[self._tick % MAX_TICKS] = max(now - self.session.due, 0.0)
        self._tick += 1
        self.session.due = now + TICK
        report = self.session.report(now)
        self.session.tally = report.tally
        packet = self._aggregator.update(now, report)
        if packet is not None and not self._send(packet):
            self._aggregator.resend()
        self._broadcaster.update(now)

    def _run_timer(self) -> None:
        """Gather by timer when no message does."""
        if self.session.now() >= self.session.due:
            guarded("gathering voices", self.gather)()
        asyncio.get_running_loop().call_later(max(self.session.due - self.session.now(), 0.001), self._run_timer)

    def _send(self, packet: tuple[Any, ...]) -> bool:
        """Send a packet to the show; return whether that was possible. The show may be blocked or gone."""
        try:
            self._channel.socket.send(encode_packet(packet))
        except OSError:
            return False
        return True

    async def report_status(self, runner: web.AppRunner) -> None:
        """Send the status periodically, and the join code whenever it changes."""
        key = ""
        while True:
            self.session.sweep()
            self._server.sweep(list(runner.server.connections) if runner.server is not None else [])
            fresh = self.session.tickets.key(self.session.now())
            if fresh != key:
                link = f"{self._link}/#{fresh}"
                key = fresh if self._send(("code", link, qr_rows(link))) else ""
            missed = self._broadcaster.missed_frames
            self._channel.send_facts({**self.session.facts(), "late_ms": self._lateness(), "missed_frames": missed})
            self._collect_garbage()
            await asyncio.sleep(STATUS_INTERVAL)

    def _collect_garbage(self) -> None:
        """Collect garbage: often only the youngest generation, once a minute all (about 50 ms with thousands of
        phones)."""
        now = self.session.now()
        whole = now - self._tidied > FULL_COLLECTION_INTERVAL
        self._tidied = now if whole else self._tidied
        gc.collect(2 if whole else 0)

    def _lateness(self) -> list[float]:
        """Return the lateness of recent ticks, median and 99th percentile [ms]: the longest wait of a message."""
        known = self._lateness_samples[: max(min(self._tick, MAX_TICKS), 1)]
        return [round(1e3 * float(value), 2) for value in np.percentile(known, (50, 99))]

    async def run(self, listening: socket.socket) -> None:
        """Serve until the show ends."""
        app = web.Application(client_max_size=1024)
        app.router.add_route("*", "/{path:.*}", self._server.answer)
        runner = web.AppRunner(app, access_log=None, handle_signals=False, keepalive_timeout=3.0)
        await runner.setup()
        asyncio.get_running_loop().add_reader(self._channel.socket, self.receive)
        self.receive()
        with contextlib.suppress(TimeoutError):  # the first phones should get the show's rules
            await asyncio.wait_for(self._has_rules.wait(), RULES_TIMEOUT)
        tls = None if self._certificate is None else server_context(*self._certificate)
        handler: Any = runner.server
        server = await asyncio.get_running_loop().create_server(
            handler, sock=listening, ssl=tls, backlog=1024,
            ssl_handshake_timeout=None if tls is None else HELLO_TIMEOUT,
            ssl_shutdown_timeout=None if tls is None else TLS_SHUTDOWN_TIMEOUT,
        )  # fmt: skip
        tasks = [
            keep_task("telling phones", self._broadcaster.run),
            keep_task("telling phones whether they are heard", self._broadcaster.run_hearing),
            keep_task("the stage for phones", self._broadcaster.run_stage),
            keep_task("the gateway's figures", lambda: self.report_status(runner)),
        ]
        self._run_timer()
        await self._ended.wait()
        for task in tasks:
            task.cancel()
        server.close()
        for phone in list(self.session.phones.by_number.values()):
            phone.transport.abort()
        await runner.cleanup()


def qr_rows(link: str) -> list[str]:
    """Return the QR code of a link as rows of 0 and 1 without margin; empty if the library is missing."""
    try:
        import segno
    except ImportError:
        return []
    return ["".join("1" if dark else "0" for dark in row) for row in segno.make(link, error="m", micro=False).matrix]


def _loop_factory() -> Callable[[], asyncio.AbstractEventLoop]:
    """Return the faster event loop if it is installed."""
    try:
        import uvloop
    except ImportError:
        return asyncio.SelectorEventLoop  # the one that waits for sockets on every system
    made: Callable[[], asyncio.AbstractEventLoop] = uvloop.new_event_loop
    return made


async def _run(told: HelperChannel, listening: socket.socket) -> None:
    await Gateway(told, told.plan).run(listening)


def main() -> None:
    """Serve until the show ends."""
    logging.disable(logging.CRITICAL)  # a traceback may contain a phone's address
    told = HelperChannel(sys.argv[1])
    raise_open_files(int(told.plan["most"]) + FILES)
    gc.collect()
    gc.freeze()
    gc.disable()  # see `_collect_garbage`
    with asyncio.Runner(loop_factory=_loop_factory()) as runner:
        runner.run(_run(told, told.listening_socket()))


if __name__ == "__main__":
    main()
