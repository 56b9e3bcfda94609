"""The process of the operator's page: HTTP for the page, a WebSocket for values both ways.

The page is made of the registry (`Surface`). What is moved there goes to the show's own OSC port, as from any other
program, so that it is checked, ranked, counted and written to the journal there. The page itself says nothing about
the show. Everything else needs the key, in a header that no page of another site can send: `Authorization: Bearer KEY`,
or where a browser opens the WebSocket, the subprotocols `live.operator, live.key.KEY`.
"""

import asyncio
import json
import secrets
import socket
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Final

from aiohttp import WSMsgType, web

from live.base.fault_isolation import FAULTS
from live.control.helper_process import Told
from live.control.layouts.surface import make_surface
from live.control.osc.osc_encode import encode
from live.control.registry.control import Plain
from live.control.registry.readings import READINGS
from live.control.registry.registry import REGISTRY
from live.control.registry.rejections import Rejection
from live.control.registry.values import READABLE, Values
from live.control.web.http_guard import (
    HEARTBEAT,
    SECURITY_HEADERS,
    BoundedServer,
    FailedKeys,
    is_own,
    page_headers,
    serve,
)
from live.control.web.task_guard import keep_task

PAGE: Final = Path(__file__).with_name("web_page.html")
MOST_CLIENTS: Final = 16
MOST_BYTES: Final = 1024
"""Of a message from the page."""
EVERY: Final = 1 / 20
PER_SECOND: Final = 200.0
"""Messages that one page may send; more are refused."""
BEHIND: Final = 1 << 15
"""Bytes that a page may not have taken yet; one that is further behind is told the newest values later."""
SAY_EVERY: Final = 1.0
PROTOCOL: Final = "live.operator"
KEY_PROTOCOL: Final = "live.key."
"""Followed by the key."""


class Client:
    """One open page."""

    def __init__(self, ws: web.WebSocketResponse, request: web.BaseRequest) -> None:
        self.ws, self.request = ws, request
        self.due: dict[str, None] = dict.fromkeys(READABLE)
        self.left, self.filled_at = PER_SECOND, 0.0

    def may(self, now: float) -> bool:
        """Whether it may send one message more."""
        self.left = min(self.left + (now - self.filled_at) * PER_SECOND, PER_SECOND)
        self.filled_at = now
        if self.left < 1.0:
            return False
        self.left -= 1.0
        return True


class WebServer:
    """Everything of one show's page. Thread: the loop's."""

    def __init__(self, told: Told) -> None:
        """In a running loop."""
        plan = told.plan
        self._told, self._key, self._show = told, str(plan["key"]).encode(), tuple(plan["osc"])
        self._hosts = tuple(str(host) for host in plan["hosts"])
        self._socket = socket.socket(fileno=plan["http"])
        self._out = socket.socket(socket.AF_INET6 if ":" in self._show[0] else socket.AF_INET, socket.SOCK_DGRAM)
        self._out.setblocking(False)
        surface = make_surface(REGISTRY, role="operator", names=plan["names"], reach=tuple(plan["half"]))
        readings = {reading.address: reading.name for reading in READINGS}
        words = {control.address: control.description for control in REGISTRY}
        pages = [asdict(page) for page in surface.pages]
        for widget in (widget for page in pages for widget in page["widgets"]):
            widget["words"] = words[widget["address"]]
        self._surface = {"name": plan["name"], "pages": pages, "readings": readings}
        self._text = PAGE.read_text(encoding="utf-8")
        self.values = Values()
        self._clients: set[Client] = set()
        self._sent = self._refused = 0
        self._over = asyncio.Event()
        self._server = BoundedServer(self._answer)
        self._failed = FailedKeys(asyncio.get_running_loop().time)

    async def run(self) -> None:
        """Serve until the show has gone."""
        runner = await serve(self._server, self._socket)
        asyncio.get_running_loop().add_reader(self._told.socket, self._hear)
        tasks = [keep_task("telling pages", self._stream), keep_task("the page's figures", self._say)]
        await self._over.wait()
        for task in tasks:
            task.cancel()
        await asyncio.gather(*(client.ws.close() for client in list(self._clients)), return_exceptions=True)
        await runner.cleanup()

    def _hear(self) -> None:
        """New values from the show."""
        for changes in self._told.packets():
            self.values.take(changes)
            for client in self._clients:
                client.due |= dict.fromkeys(changes)
        if self._told.ended:
            self._over.set()

    async def _answer(self, request: web.BaseRequest) -> web.StreamResponse:
        """The page for everybody who asks here by one of our names; the rest for whoever has the key."""
        if not is_own(request, self._hosts):
            return self._refuse(403)
        if request.path not in ("/", "/surface.json", "/ws"):
            return self._refuse(404)
        if request.method not in ("GET", "HEAD"):
            return self._refuse(405)
        if request.path == "/":
            headers = page_headers(self._text, request.headers["Host"].casefold())
            return web.Response(text=self._text, content_type="text/html", headers=headers)
        if not self._knows_key(request):
            self._refused += 1
            return await self._failed.answer(request)
        if request.path == "/surface.json":
            return web.json_response(self._surface, headers=SECURITY_HEADERS)
        return await self._open(request)

    def _refuse(self, status: int) -> web.Response:
        self._refused += 1
        return web.Response(status=status, headers=SECURITY_HEADERS)

    def _knows_key(self, request: web.BaseRequest) -> bool:
        scheme, _, brought = request.headers.get("Authorization", "").partition(" ")
        if scheme.casefold() != "bearer":
            offered = [each.strip() for each in request.headers.get("Sec-WebSocket-Protocol", "").split(",")]
            keys = [each.removeprefix(KEY_PROTOCOL) for each in offered if each.startswith(KEY_PROTOCOL)]
            brought = keys[0] if keys and PROTOCOL in offered else ""
        # an empty key is none
        return bool(self._key) and secrets.compare_digest(brought.encode(errors="replace"), self._key)

    async def _open(self, request: web.BaseRequest) -> web.StreamResponse:
        if request.headers.get("Upgrade", "").casefold() != "websocket":
            return self._refuse(400)
        if len(self._clients) >= MOST_CLIENTS:
            return self._refuse(503)
        ws = web.WebSocketResponse(
            max_msg_size=MOST_BYTES, heartbeat=HEARTBEAT, compress=False, timeout=1.0, protocols=(PROTOCOL,)
        )
        await ws.prepare(request)
        self._server.keep(request)
        client = Client(ws, request)
        self._clients.add(client)
        try:
            async for message in ws:
                why = self._take(client, message.data) if message.type is WSMsgType.TEXT else "text expected"
                if why:
                    self._refused += 1
                    await ws.send_str(json.dumps({"refused": why}))
        except (ConnectionError, RuntimeError):  # it has gone meanwhile
            pass
        finally:
            self._clients.discard(client)
        return ws

    def _take(self, client: Client, text: str) -> str:
        """A message {"address": …, "values": […]} goes to the show; why not, in words, or nothing."""
        if not client.may(asyncio.get_running_loop().time()):
            return "too much at once"
        try:
            told = json.loads(text)
            address, values = told["address"], told["values"]
        except (ValueError, TypeError, KeyError, RecursionError):
            return "an address and values expected"
        if not isinstance(address, str) or not isinstance(values, list) or len(values) > 8:
            return "an address and values expected"
        made = REGISTRY.call(address, values, 0.0, "web")
        if isinstance(made, Rejection):
            return str(made)
        try:
            self._out.sendto(encode(address, tuple(values)), self._show)
        except (OSError, ValueError, OverflowError) as error:
            return f"the show does not listen: {error}"
        self._sent += 1
        return ""

    async def _stream(self) -> None:
        while True:
            await asyncio.sleep(EVERY)
            for client in list(self._clients):
                if client.due:
                    try:
                        await self._tell(client)
                    except (ConnectionError, RuntimeError):  # it has gone
                        pass
                    except Exception as error:  # one that cannot be told anything is not told anything
                        FAULTS.note("telling one client", error)
                        self._clients.discard(client)

    async def _tell(self, client: Client) -> None:
        """Send what has changed: of a value that groups have each their own the first; of named ones each."""
        transport = client.request.transport
        if transport is None or transport.get_write_buffer_size() > BEHIND:
            return  # who has gone is noticed by pings; nobody else waits for it
        due, client.due = client.due, {}
        told: dict[str, list[Plain]] = {}
        for address in due:
            control = REGISTRY.find(address)
            if control is not None and control.named:
                told |= {where: list(values) for where, values in self.values.messages(address) if where != address}
            elif rows := self.values.rows(address):
                told[address] = list(rows[0][1])
        if told:
            await client.ws.send_str(json.dumps({"values": told}))

    async def _say(self) -> None:
        while True:
            facts = {"pages": len(self._clients), "sent": self._sent, "refused": self._refused}
            self._told.say(facts | {"wrong_keys": self._failed.count, "dropped": self._server.dropped})
            await asyncio.sleep(SAY_EVERY)


async def _run(told: Told) -> None:
    await WebServer(told).run()


if __name__ == "__main__":
    asyncio.run(_run(Told(int(sys.argv[1]))))
