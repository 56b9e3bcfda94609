"""Gateway process: serves the audience's phones and sends their aggregated input to the show.

It reads no files of a show, stores no personal data and writes nothing to disk. Phones cannot send free text: see
`phone_protocol`. The listening socket belongs to the show, so phones that join during a restart wait in its backlog.
"""

import asyncio
import contextlib
import gc
import logging
import resource
import socket
import sys
from collections.abc import Callable
from typing import Any, Final

import numpy as np
from aiohttp import web

from live.clock.ticks import TICK
from live.control.audience.broadcaster import Teller
from live.control.audience.http_server import HELLO_WITHIN, Door
from live.control.audience.session_state import Beat, Hall, Rules
from live.control.audience.tls import server_context
from live.control.helper_process import Told
from live.control.message_codec import packet_of
from live.control.web.task_guard import guarded, keep_task

SAY_EVERY: Final = 0.5
RULES_WITHIN: Final = 1.0
"""Time to wait for the show's rules [s] before phones are accepted."""
TIDY_EVERY: Final = 60.0
TURNS: Final = 1024
"""Number of ticks whose lateness is recorded: 16 s."""
FILES: Final = 1024
"""Additional file descriptors besides one per phone."""
PARTS_WITHIN: Final = 2.0
"""Time-out of the TLS shutdown [s]."""


class Gateway:
    """Gateway of one show. Thread: the loop's."""

    def __init__(self, told: Told, plan: dict[str, Any]) -> None:
        self._told, self._secret, self._link = told, bytes(plan["secret"]), str(plan["link"])
        self._certificate: tuple[bytes, bytes] | None = plan.get("certificate")
        self.hall = Hall(plan)
        self._teller = Teller(self.hall)
        self.hall.gather = self.gather
        self._door = Door(self.hall, self._teller, self._secret, plan)
        self._over = asyncio.Event()
        self._ruled = asyncio.Event()
        self._late = np.zeros(TURNS)
        self._turn = 0
        self._tidied = self.hall.now()

    def hear(self) -> None:
        """Handle packets from the show."""
        for packet in self._told.packets():
            if isinstance(packet, Rules):
                self.hall.rule(packet)
                self._teller.take(packet)
                self._ruled.set()
                self.gather()  # the operator's change applies at once, not a tick later
            elif isinstance(packet, Beat):
                self.hall.beat = packet
                self._teller.look(packet)
        if self._told.ended:
            self._over.set()
            self._ruled.set()

    def gather(self) -> None:
        """Send the aggregate to the show: once per tick, and at once after a command of the operator.

        A message that is handled when a tick is due also calls this, because timers are late under load.
        """
        now = self.hall.now()
        self._late[self._turn % TURNS] = max(now - self.hall.due, 0.0)
        self._turn += 1
        self.hall.due = now + TICK
        packet = self.hall.turn(now)
        if packet is not None and not self._send(packet):
            self.hall.together.unsaid()
        self._teller.look_at_lights()

    def _clock(self) -> None:
        """Gather by timer when no message does."""
        if self.hall.now() >= self.hall.due:
            guarded("gathering voices", self.gather)()
        asyncio.get_running_loop().call_later(max(self.hall.due - self.hall.now(), 0.001), self._clock)

    def _send(self, packet: tuple[Any, ...]) -> bool:
        """Send a packet to the show; return whether that was possible. The show may be blocked or gone."""
        try:
            self._told.socket.send(packet_of(packet))
        except OSError:
            return False
        return True

    async def say(self, runner: web.AppRunner) -> None:
        """Send the status periodically, and the join code whenever it changes."""
        key = ""
        while True:
            self.hall.sweep()
            self._door.sweep(list(runner.server.connections) if runner.server is not None else [])
            fresh = self.hall.tickets.key(self.hall.now())
            if fresh != key:
                link = f"{self._link}/#{fresh}"
                key = fresh if self._send(("code", link, code_of(link))) else ""
            self._told.say({**self.hall.facts(), "late_ms": self._lateness()})
            self._tidy()
            await asyncio.sleep(SAY_EVERY)

    def _tidy(self) -> None:
        """Collect garbage: often only the youngest generation, once a minute all (about 50 ms with thousands of
        phones)."""
        now = self.hall.now()
        whole = now - self._tidied > TIDY_EVERY
        self._tidied = now if whole else self._tidied
        gc.collect(2 if whole else 0)

    def _lateness(self) -> list[float]:
        """Return the lateness of recent ticks, median and 99th percentile [ms]: the longest wait of a message."""
        known = self._late[: max(min(self._turn, TURNS), 1)]
        return [round(1e3 * float(value), 2) for value in np.percentile(known, (50, 99))]

    async def run(self, listening: socket.socket) -> None:
        """Serve until the show ends."""
        app = web.Application(client_max_size=1024)
        app.router.add_route("*", "/{path:.*}", self._door.answer)
        runner = web.AppRunner(app, access_log=None, handle_signals=False, keepalive_timeout=3.0)
        await runner.setup()
        asyncio.get_running_loop().add_reader(self._told.socket, self.hear)
        self.hear()
        with contextlib.suppress(TimeoutError):  # the first phones should get the show's rules
            await asyncio.wait_for(self._ruled.wait(), RULES_WITHIN)
        tls = None if self._certificate is None else server_context(*self._certificate)
        handler: Any = runner.server
        server = await asyncio.get_running_loop().create_server(
            handler, sock=listening, ssl=tls, backlog=1024, ssl_handshake_timeout=None if tls is None else HELLO_WITHIN,
            ssl_shutdown_timeout=None if tls is None else PARTS_WITHIN,
        )  # fmt: skip
        tasks = [
            keep_task("telling phones", self._teller.run),
            keep_task("the phones' lights", self._teller.lights),
            keep_task("the gateway's figures", lambda: self.say(runner)),
        ]
        self._clock()
        await self._over.wait()
        for task in tasks:
            task.cancel()
        server.close()
        for phone in list(self.hall.phones.by_number.values()):
            phone.transport.abort()
        await runner.cleanup()


def code_of(link: str) -> list[str]:
    """Return the QR code of a link as rows of 0 and 1 without margin; empty if the library is missing."""
    try:
        import segno
    except ImportError:
        return []
    return ["".join("1" if dark else "0" for dark in row) for row in segno.make(link, error="m", micro=False).matrix]


def _more_files(wanted: int) -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft < wanted:
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (min(wanted, hard), hard))


def _loop_factory() -> Callable[[], asyncio.AbstractEventLoop]:
    """Return the faster event loop if it is installed."""
    try:
        import uvloop
    except ImportError:
        return asyncio.new_event_loop
    made: Callable[[], asyncio.AbstractEventLoop] = uvloop.new_event_loop
    return made


async def _run(told: Told, listening: socket.socket) -> None:
    await Gateway(told, told.plan).run(listening)


def main() -> None:
    """Serve until the show ends."""
    logging.disable(logging.CRITICAL)  # a traceback may contain a phone's address
    told = Told(int(sys.argv[1]))
    _more_files(int(told.plan["most"]) + FILES)
    gc.collect()
    gc.freeze()
    gc.disable()  # see `_tidy`
    with asyncio.Runner(loop_factory=_loop_factory()) as runner:
        runner.run(_run(told, socket.socket(fileno=told.plan["http"])))


if __name__ == "__main__":
    main()
