"""The gateway: the process that the audience's phones talk to, and that tells the show what they want together.

It knows no file of a show, keeps nothing of a person, writes nothing down. Phones have no words of their own: see
`wire`. The socket that it listens at is the show's: while it is started again, who wants to join waits in it.
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
"""The show says soon [s] what is allowed; then the doors open."""
TIDY_EVERY: Final = 60.0
TURNS: Final = 1024
"""Turns of which it is known how late they were: 16 s."""
FILES: Final = 1024
"""Descriptors beside one for each phone."""
PARTS_WITHIN: Final = 2.0
"""An encrypted connection says good-bye so soon [s], or is cut."""


class Gateway:
    """Everything of one show. Thread: the loop's."""

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
        """What has come from the show."""
        for packet in self._told.packets():
            if isinstance(packet, Rules):
                self.hall.rule(packet)
                self._teller.take(packet)
                self._ruled.set()
                self.gather()  # what the operator says counts at once, not a tick later
            elif isinstance(packet, Beat):
                self.hall.beat = packet
                self._teller.look(packet)
        if self._told.ended:
            self._over.set()
            self._ruled.set()

    def gather(self) -> None:
        """Tell the show what all want together: once a tick, and at once after a word of the operator.

        Whoever hears a message when it is due calls this, too: while many come, no timer is punctual.
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
        """A timer that gathers when nobody else does."""
        if self.hall.now() >= self.hall.due:
            guarded("gathering voices", self.gather)()
        asyncio.get_running_loop().call_later(max(self.hall.due - self.hall.now(), 0.001), self._clock)

    def _send(self, packet: tuple[Any, ...]) -> bool:
        """Tell the show something; whether it could be: it may stand still, or have gone."""
        try:
            self._told.socket.send(packet_of(packet))
        except OSError:
            return False
        return True

    async def say(self, runner: web.AppRunner) -> None:
        """Tell how things are, for the status; and the code, whenever it is another one."""
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
        """Free what is held in circles: little and often, and all of it (some 50 ms with thousands) once a minute."""
        now = self.hall.now()
        whole = now - self._tidied > TIDY_EVERY
        self._tidied = now if whole else self._tidied
        gc.collect(2 if whole else 0)

    def _lateness(self) -> list[float]:
        """How late the last turns were, median and 99 of 100 [ms]: so long a message waits at most to be read."""
        known = self._late[: max(min(self._turn, TURNS), 1)]
        return [round(1e3 * float(value), 2) for value in np.percentile(known, (50, 99))]

    async def run(self, listening: socket.socket) -> None:
        """Serve until the show has gone."""
        app = web.Application(client_max_size=1024)
        app.router.add_route("*", "/{path:.*}", self._door.answer)
        runner = web.AppRunner(app, access_log=None, handle_signals=False, keepalive_timeout=3.0)
        await runner.setup()
        asyncio.get_running_loop().add_reader(self._told.socket, self.hear)
        self.hear()
        with contextlib.suppress(TimeoutError):  # whoever comes in is to find the rules of the show
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
    """The QR code of a link: rows of 0 and 1, without the white around it; empty where the library is missing."""
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
    """The faster loop, where there is one."""
    try:
        import uvloop
    except ImportError:
        return asyncio.new_event_loop
    made: Callable[[], asyncio.AbstractEventLoop] = uvloop.new_event_loop
    return made


async def _run(told: Told, listening: socket.socket) -> None:
    await Gateway(told, told.plan).run(listening)


def main() -> None:
    """Serve until the show has gone."""
    logging.disable(logging.CRITICAL)  # a traceback may name somebody's address
    told = Told(int(sys.argv[1]))
    _more_files(int(told.plan["most"]) + FILES)
    gc.collect()
    gc.freeze()
    gc.disable()  # see `_tidy`
    with asyncio.Runner(loop_factory=_loop_factory()) as runner:
        runner.run(_run(told, socket.socket(fileno=told.plan["http"])))


if __name__ == "__main__":
    main()
