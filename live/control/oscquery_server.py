"""The process that answers OSCQuery: HTTP, a WebSocket that streams values (LISTEN), and zeroconf to be found by.

Only GET is understood, nothing can be changed here, and pages of other sites are refused (Origin and Host are checked):
what is set is set over OSC.
"""

import asyncio
import contextlib
import json
import socket
import sys
from typing import Any, Final

from aiohttp import WSMsgType, web

from live.control.helper import Told
from live.control.http_guard import welcome
from live.control.osc_encode import bundles, encode
from live.control.oscquery import Namespace, host_info
from live.control.registry import REGISTRY
from live.control.values import READABLE, Rows, Values

MOST_CLIENTS: Final = 32
MOST_BYTES: Final = 1024
"""Of a message from a client."""
EVERY: Final = 1 / 30
BEHIND: Final = 1 << 18
"""Bytes that a client may not have taken yet; one that is further behind is left."""
SAY_EVERY: Final = 1.0


class Listener:
    """One WebSocket client."""

    def __init__(self, ws: web.WebSocketResponse, request: web.Request) -> None:
        self.ws, self._request = ws, request
        self.paths: set[str] = set()
        self.due: dict[str, None] = {}
        self.told: dict[str, Rows] = {}

    async def tell(self, values: Values) -> None:
        """Send what has changed, as OSC."""
        due, self.due = self.due, {}
        messages = []
        for address in due:
            rows = values.rows(address)
            if rows and self.told.get(address) != rows:
                self.told[address] = rows
                messages += [encode(where, row) for where, row in values.messages(address)]
        transport = self._request.transport
        if transport is None or transport.get_write_buffer_size() > BEHIND:
            await self.ws.close()
            return
        for datagram in bundles(messages):
            await self.ws.send_bytes(datagram)


class Server:
    """Everything of one show. Thread: the loop's."""

    def __init__(self, told: Told) -> None:
        plan = told.plan
        self._told, self._name, self._osc = told, str(plan["name"]), plan["osc"]
        self._socket = socket.socket(fileno=plan["http"])
        self._http = self._socket.getsockname()[:2]
        self.values = Values()
        self._tree = Namespace(self.values)
        self._listeners: set[Listener] = set()
        self._requests = self._refused = 0
        self._problem = ""
        self._over = asyncio.Event()

    async def run(self) -> None:
        """Answer until the show has gone."""
        app = web.Application(client_max_size=MOST_BYTES)
        app.router.add_get("/{path:.*}", self._answer)
        runner = web.AppRunner(app, access_log=None, handle_signals=False)
        await runner.setup()
        await web.SockSite(runner, self._socket, backlog=32).start()
        asyncio.get_running_loop().add_reader(self._told.socket, self._hear)
        announced = await self._announce()
        tasks = [asyncio.create_task(self._stream()), asyncio.create_task(self._say())]
        await self._over.wait()
        for task in tasks:
            task.cancel()
        for listener in list(self._listeners):
            await listener.ws.close()
        if announced is not None:
            await announced.async_unregister_all_services()
            await announced.async_close()
        await runner.cleanup()

    def _hear(self) -> None:
        """New values from the show."""
        for changes in self._told.packets():
            self.values.take(changes)
            for listener in self._listeners:
                listener.due |= dict.fromkeys(path for path in listener.paths if REGISTRY.kept_at(path)[0] in changes)
        if self._told.ended:
            self._over.set()

    async def _answer(self, request: web.Request) -> web.StreamResponse:
        self._requests += 1
        if not welcome(request):
            self._refused += 1
            raise web.HTTPForbidden
        if request.headers.get("Upgrade", "").lower() == "websocket":
            return await self._listen(request)
        path, asked = "/" + request.match_info["path"], request.query_string
        if asked == "HOST_INFO":
            return _json(host_info(self._name, self._osc, self._http))
        if not self._tree.has(path):
            raise web.HTTPNotFound
        if not asked:
            return _json(self._tree.node(path))
        try:
            found = self._tree.attribute(path, asked)
        except KeyError:
            raise web.HTTPBadRequest from None
        if found is None:
            raise web.HTTPNoContent
        return _json(found)

    async def _listen(self, request: web.Request) -> web.StreamResponse:
        if len(self._listeners) >= MOST_CLIENTS:
            self._refused += 1
            raise web.HTTPServiceUnavailable
        ws = web.WebSocketResponse(max_msg_size=MOST_BYTES, heartbeat=10.0, compress=False)
        await ws.prepare(request)
        listener = Listener(ws, request)
        self._listeners.add(listener)
        try:
            async for message in ws:
                if message.type is not WSMsgType.TEXT or not self._take(listener, message.data):
                    self._refused += 1
        finally:
            self._listeners.discard(listener)
        return ws

    def _take(self, listener: Listener, text: str) -> bool:
        """LISTEN or IGNORE; whether it was understood."""
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
                    with contextlib.suppress(ConnectionError, RuntimeError):
                        await listener.tell(self.values)

    async def _say(self) -> None:
        while True:
            facts: dict[str, Any] = {"at": f"{self._http[0]}:{self._http[1]}", "clients": len(self._listeners)}
            facts |= {"requests": self._requests, "refused": self._refused, "problem": self._problem}
            self._told.say(facts)
            await asyncio.sleep(SAY_EVERY)

    async def _announce(self) -> Any:
        """Be found by programs that look for OSCQuery or OSC in the network; what fails is said in the status."""
        try:
            from zeroconf import InterfaceChoice
            from zeroconf.asyncio import AsyncServiceInfo, AsyncZeroconf

            host = self._http[0]
            everywhere = host in ("0.0.0.0", "::")
            found = AsyncZeroconf(interfaces=InterfaceChoice.All if everywhere else [host])
            addresses = _own_addresses() if everywhere else [host]
            name = "".join(c for c in self._name if c.isalnum() or c in " -_")[:40].strip() or "Live"
            for kind, port in (("_oscjson._tcp.local.", self._http[1]), ("_osc._udp.local.", self._osc[1])):
                info = AsyncServiceInfo(kind, f"{name}.{kind}", parsed_addresses=addresses, port=port,
                                        server=f"live-{self._http[1]}.local.")  # fmt: skip
                await found.async_register_service(info, allow_name_change=True)
        except Exception as error:  # no multicast, no interface, another program in the way: HTTP is there all the same
            self._problem = f"not to be found by zeroconf: {type(error).__name__}: {error}"
            return None
        return found


def _own_addresses() -> list[str]:
    import ifaddr

    found = [str(ip.ip) for adapter in ifaddr.get_adapters() for ip in adapter.ips if ip.is_IPv4]
    return [address for address in found if not address.startswith("127.")] or ["127.0.0.1"]


def _json(facts: dict[str, Any]) -> web.Response:
    return web.json_response(facts, headers={"Cache-Control": "no-store", "X-Content-Type-Options": "nosniff"})


async def _run(told: Told) -> None:
    await Server(told).run()


if __name__ == "__main__":
    asyncio.run(_run(Told(int(sys.argv[1]))))
