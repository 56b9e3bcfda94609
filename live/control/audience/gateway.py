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
from typing import Any, Final

import numpy as np
from aiohttp import web

from live.base.system.process_control import raise_open_files
from live.clock.ticks import TICK
from live.control.audience.broadcaster import Broadcaster
from live.control.audience.http_server import HELLO_TIMEOUT, HttpServer
from live.control.audience.session_state import BeatClock, Rules, SessionState
from live.control.audience.uplink import ShowUplink, Uplink
from live.control.helper_process import HelperChannel
from live.control.tls import server_context
from live.control.web.task_guard import guarded, keep_task, loop_factory

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

    def __init__(self, uplink: Uplink, plan: dict[str, Any]) -> None:
        self._uplink, self._certificate = uplink, plan.get("certificate")
        self.session = SessionState(plan)
        self._broadcaster = Broadcaster(self.session)
        self.session.gather = self.gather
        self._server = HttpServer(self.session, self._broadcaster, bytes(plan["secret"]), plan)
        self._ended = asyncio.Event()
        self._has_rules = asyncio.Event()
        self._lateness_samples = np.zeros(MAX_TICKS)
        self._tick = 0
        self._tidied = self.session.now()

    def handle(self, packet: Any) -> None:
        """Handle a packet from the show."""
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

    def end(self) -> None:
        """Let `run` return."""
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
        self.session.tally = self._uplink.publish(self.session.report(now), now)
        self._broadcaster.update(now)

    def _run_timer(self) -> None:
        """Gather by timer when no message does."""
        if self.session.now() >= self.session.due:
            guarded("gathering voices", self.gather)()
        asyncio.get_running_loop().call_later(max(self.session.due - self.session.now(), 0.001), self._run_timer)

    async def report_status(self, runner: web.AppRunner) -> None:
        """Send the status periodically."""
        while True:
            self.session.sweep()
            self._server.sweep(list(runner.server.connections) if runner.server is not None else [])
            facts = {"late_ms": self._lateness(), "missed_frames": self._broadcaster.missed_frames}
            self._uplink.report_facts(self.session.facts() | facts, self.session.now())
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
        self._uplink.start(self.handle, self.end)
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


async def _run(told: HelperChannel) -> None:
    await Gateway(ShowUplink(told, told.plan), told.plan).run(told.listening_socket())


def prepare_process(phones: int) -> None:
    """Prepare this process for so many phones."""
    logging.disable(logging.CRITICAL)  # a traceback may contain a phone's address
    raise_open_files(phones + FILES)
    gc.collect()
    gc.freeze()
    gc.disable()  # see `Gateway._collect_garbage`


def main() -> None:
    """Serve until the show ends."""
    told = HelperChannel(sys.argv[1])
    prepare_process(int(told.plan["most"]))
    with asyncio.Runner(loop_factory=loop_factory()) as runner:
        runner.run(_run(told))


if __name__ == "__main__":
    main()
