"""OSCQuery server process: HTTP, a WebSocket that streams values (LISTEN), and zeroconf announcement.

It is read-only (GET), so it needs no key; values are set over OSC. Requests from pages of other sites are refused
(Origin and Host are checked).
"""

import asyncio
import ipaddress
import json
import socket
import sys
from collections import Counter
from typing import Any, Final

from aiohttp import WSMsgType, web

from live.base.fault_isolation import FAULTS
from live.control.helper_process import Told
from live.control.osc.osc_codec import bundles, encode
from live.control.osc.oscquery_tree import Namespace, host_info
from live.control.registry.registry import READABLE, REGISTRY, Rows, Values
from live.control.web.mdns import Announcement, service_host
from live.control.web.task_guard import keep_task
from live.control.web.web_server import (
    HEARTBEAT,
    SECURITY_HEADERS,
    BoundedServer,
    address_group,
    is_own,
    serve,
)

MOST_CLIENTS: Final = 32
MOST_OF_ONE: Final = 16
"""Maximum number of clients of one address group."""
MOST_BYTES: Final = 1024
"""Maximum size of a client's message."""
EVERY: Final = 1 / 30
BEHIND: Final = 1 << 15
"""Maximum number of unread bytes per client; a client further behind gets the newest values later."""
SAY_EVERY: Final = 1.0


class Listener:
    """One WebSocket client."""

    def __init__(self, ws: web.WebSocketResponse, request: web.BaseRequest) -> None:
        self.ws, self._request = ws, request
        self.paths: set[str] = set()
        self.due: dict[str, None] = {}
        self.told: dict[str, Rows] = {}

    async def tell(self, values: Values) -> None:
        """Send changed values as OSC."""
        transport = self._request.transport
        if transport is None or transport.get_write_buffer_size() > BEHIND:
            return  # pings detect a client that is gone
        due, self.due = self.due, {}
        messages = []
        for address in due:
            rows = values.rows(address)
            if rows and self.told.get(address) != rows:
                self.told[address] = rows
                messages += [encode(where, row) for where, row in values.messages(address)]
        for datagram in bundles(messages):
            await self.ws.send_bytes(datagram)


class Server:
    """OSCQuery server of one show. Use from the event loop's thread."""

    def __init__(self, told: Told) -> None:
        """Needs a running event loop."""
        plan = told.plan
        self._told, self._name, self._osc = told, str(plan["name"]), (str(plan["osc"][0]), int(plan["osc"][1]))
        self._socket = socket.socket(fileno=plan["http"])
        self._http = self._socket.getsockname()[:2]
        self.values = Values()
        self._tree = Namespace(self.values)
        self._hosts = tuple(str(host) for host in plan["hosts"])
        if not ipaddress.ip_address(self._http[0]).is_loopback:
            self._hosts += (service_host(self._http[1]),)
        self._listeners: set[Listener] = set()
        self._of_group: Counter[str] = Counter()
        self._requests = self._refused = 0
        self._problem = ""
        self._over = asyncio.Event()
        self._server = BoundedServer(self._answer)

    async def run(self) -> None:
        """Serve until the show closes the channel."""
        runner = await serve(self._server, self._socket)
        asyncio.get_running_loop().add_reader(self._told.socket, self._hear)
        announcement = Announcement(self._name, self._http, self._osc[1])
        self._problem = await announcement.begin()
        tasks = [keep_task("streaming of OSCQuery", self._stream), keep_task("the figures of OSCQuery", self._say)]
        await self._over.wait()
        for task in tasks:
            task.cancel()
        await asyncio.gather(*(each.ws.close() for each in list(self._listeners)), return_exceptions=True)
        await announcement.end()
        await runner.cleanup()

    def _hear(self) -> None:
        """Read new values from the show."""
        for changes in self._told.packets():
            self.values.take(changes)
            for listener in self._listeners:
                listener.due |= dict.fromkeys(path for path in listener.paths if REGISTRY.kept_at(path)[0] in changes)
        if self._told.ended:
            self._over.set()

    async def _answer(self, request: web.BaseRequest) -> web.StreamResponse:
        self._requests += 1
        if not is_own(request, self._hosts):
            return self._refuse(403)
        if request.method not in ("GET", "HEAD"):
            return self._refuse(405)
        if request.headers.get("Upgrade", "").casefold() == "websocket":
            return await self._listen(request)
        path, asked = request.path, request.query_string
        if asked == "HOST_INFO":
            return _json(host_info(self._name, self._osc, self._http))
        if not self._tree.has(path):
            return web.Response(status=404, headers=SECURITY_HEADERS)
        if not asked:
            return _json(self._tree.node(path))
        try:
            found = self._tree.attribute(path, asked)
        except KeyError:
            return web.Response(status=400, headers=SECURITY_HEADERS)
        return web.Response(status=204, headers=SECURITY_HEADERS) if found is None else _json(found)

    def _refuse(self, status: int) -> web.Response:
        self._refused += 1
        return web.Response(status=status, headers=SECURITY_HEADERS)

    async def _listen(self, request: web.BaseRequest) -> web.StreamResponse:
        group = address_group(request.remote or "")
        if len(self._listeners) >= MOST_CLIENTS or self._of_group[group] >= MOST_OF_ONE:
            return self._refuse(503)
        ws = web.WebSocketResponse(max_msg_size=MOST_BYTES, heartbeat=HEARTBEAT, compress=False, timeout=1.0)
        await ws.prepare(request)
        self._server.keep(request)
        listener = Listener(ws, request)
        self._listeners.add(listener)
        self._of_group[group] += 1
        try:
            async for message in ws:
                if message.type is not WSMsgType.TEXT or not self._take(listener, message.data):
                    self._refused += 1
        finally:
            self._listeners.discard(listener)
            self._of_group -= Counter({group: 1})
        return ws

    def _take(self, listener: Listener, text: str) -> bool:
        """Handle LISTEN or IGNORE; return whether it was valid."""
        try:
            order = json.loads(text)
            command, path = order["COMMAND"], order["DATA"]
        except (ValueError, TypeError, KeyError, RecursionError):
            return False
        if not isinstance(path, str) or command not in ("LISTEN", "IGNORE"):
            return False
        address = path.rstrip("/")
        if REGISTRY.kept_at(address)[0] not in READABLE or not self._tree.has(address):
            return False
        if command == "LISTEN":
            listener.paths.add(address)
            listener.due[address] = None
        else:
            listener.paths.discard(address)
            listener.told.pop(address, None)
        return True

    async def _stream(self) -> None:
        while True:
            await asyncio.sleep(EVERY)
            for listener in list(self._listeners):
                if listener.due:
                    try:
                        await listener.tell(self.values)
                    except (ConnectionError, RuntimeError):  # disconnected
                        pass
                    except Exception as error:  # drop a listener that cannot be served
                        FAULTS.note("telling one listener", error)
                        self._listeners.discard(listener)

    async def _say(self) -> None:
        while True:
            facts: dict[str, Any] = {"at": f"{self._http[0]}:{self._http[1]}", "clients": len(self._listeners)}
            facts |= {"requests": self._requests, "refused": self._refused, "problem": self._problem}
            facts["dropped"] = self._server.dropped
            self._told.say(facts)
            await asyncio.sleep(SAY_EVERY)


def _json(facts: dict[str, Any]) -> web.Response:
    return web.json_response(facts, headers=SECURITY_HEADERS)


async def _run(told: Told) -> None:
    await Server(told).run()


if __name__ == "__main__":
    asyncio.run(_run(Told(int(sys.argv[1]))))
