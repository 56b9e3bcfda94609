"""OSCQuery server process: HTTP, a WebSocket that streams values (LISTEN), and zeroconf announcement.

It is read-only (GET), so it needs no key; values are set over OSC. Requests from pages of other sites are refused
(Origin and Host are checked).
"""

import asyncio
import ipaddress
import json
import sys
from collections import Counter
from typing import Any, Final

from aiohttp import WSMsgType, web

from live.base.fault_isolation import FAULTS
from live.bridges.oscquery.oscquery_tree import Namespace, host_info
from live.control.helper_process import HelperChannel
from live.control.osc.osc_codec import bundles, encode
from live.control.registry.registry import READABLE, REGISTRY, Rows, Values
from live.control.web.http_protection import (
    HEARTBEAT,
    SECURITY_HEADERS,
    BoundedServer,
    address_group,
    is_same_origin,
    serve,
)
from live.control.web.mdns import Announcement, service_host
from live.control.web.task_guard import keep_task

MAX_CLIENTS: Final = 32
MAX_CLIENTS_PER_GROUP: Final = 16
"""Maximum number of clients of one address group."""
MAX_MESSAGE_BYTES: Final = 1024
"""Maximum size of a client's message."""
UPDATE_INTERVAL: Final = 1 / 30
MAX_UNREAD_BYTES: Final = 1 << 15
"""Maximum number of unread bytes per client; a client further behind gets the newest values later."""
STATUS_INTERVAL: Final = 1.0


class Listener:
    """One WebSocket client."""

    def __init__(self, ws: web.WebSocketResponse, request: web.BaseRequest) -> None:
        self.ws, self._request = ws, request
        self.paths: set[str] = set()
        self.due: dict[str, None] = {}
        self.last_sent: dict[str, Rows] = {}

    async def send_changes(self, values: Values) -> None:
        """Send changed values as OSC."""
        transport = self._request.transport
        if transport is None or transport.get_write_buffer_size() > MAX_UNREAD_BYTES:
            return  # pings detect a client that is gone
        due, self.due = self.due, {}
        messages = []
        for address in due:
            rows = values.rows(address)
            if rows and self.last_sent.get(address) != rows:
                self.last_sent[address] = rows
                messages += [encode(where, row) for where, row in values.messages(address)]
        for datagram in bundles(messages):
            await self.ws.send_bytes(datagram)


class OscQueryServer:
    """OSCQuery server of one show. Use from the event loop's thread."""

    def __init__(self, channel: HelperChannel) -> None:
        """Needs a running event loop."""
        plan = channel.plan
        self._channel, self._name, self._osc = channel, str(plan["name"]), (str(plan["osc"][0]), int(plan["osc"][1]))
        self._socket = channel.listening_socket()
        self._http = self._socket.getsockname()[:2]
        self.values = Values()
        self._tree = Namespace(self.values)
        self._hosts = tuple(str(host) for host in plan["hosts"])
        if not ipaddress.ip_address(self._http[0]).is_loopback:
            self._hosts += (service_host(self._http[1]),)
        self._listeners: set[Listener] = set()
        self._group_counts: Counter[str] = Counter()
        self._requests = self._refused = 0
        self._problem = ""
        self._stopped = asyncio.Event()
        self._server = BoundedServer(self._answer)

    async def run(self) -> None:
        """Serve until the show closes the channel."""
        runner = await serve(self._server, self._socket)
        asyncio.get_running_loop().add_reader(self._channel.socket, self._read_values)
        announcement = Announcement(self._name, self._http, self._osc[1])
        self._problem = await announcement.start()
        tasks = [
            keep_task("streaming of OSCQuery", self._stream),
            keep_task("the figures of OSCQuery", self._report_status),
        ]
        await self._stopped.wait()
        for task in tasks:
            task.cancel()
        await asyncio.gather(*(each.ws.close() for each in list(self._listeners)), return_exceptions=True)
        await announcement.stop()
        await runner.cleanup()

    def _read_values(self) -> None:
        """Read new values from the show."""
        for changes in self._channel.packets():
            self.values.update(changes)
            for listener in self._listeners:
                listener.due |= dict.fromkeys(
                    path for path in listener.paths if REGISTRY.storage_key(path)[0] in changes
                )
        if self._channel.closed:
            self._stopped.set()

    async def _answer(self, request: web.BaseRequest) -> web.StreamResponse:
        self._requests += 1
        if not is_same_origin(request, self._hosts):
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
        if len(self._listeners) >= MAX_CLIENTS or self._group_counts[group] >= MAX_CLIENTS_PER_GROUP:
            return self._refuse(503)
        ws = web.WebSocketResponse(max_msg_size=MAX_MESSAGE_BYTES, heartbeat=HEARTBEAT, compress=False, timeout=1.0)
        await ws.prepare(request)
        self._server.release(request)
        listener = Listener(ws, request)
        self._listeners.add(listener)
        self._group_counts[group] += 1
        try:
            async for message in ws:
                if message.type is not WSMsgType.TEXT or not self._handle_command(listener, message.data):
                    self._refused += 1
        finally:
            self._listeners.discard(listener)
            self._group_counts -= Counter({group: 1})
        return ws

    def _handle_command(self, listener: Listener, text: str) -> bool:
        """Handle LISTEN or IGNORE; return whether it was valid."""
        try:
            order = json.loads(text)
            command, path = order["COMMAND"], order["DATA"]
        except (ValueError, TypeError, KeyError, RecursionError):
            return False
        if not isinstance(path, str) or command not in ("LISTEN", "IGNORE"):
            return False
        address = path.rstrip("/")
        if REGISTRY.storage_key(address)[0] not in READABLE or not self._tree.has(address):
            return False
        if command == "LISTEN":
            listener.paths.add(address)
            listener.due[address] = None
        else:
            listener.paths.discard(address)
            listener.last_sent.pop(address, None)
        return True

    async def _stream(self) -> None:
        while True:
            await asyncio.sleep(UPDATE_INTERVAL)
            for listener in list(self._listeners):
                if listener.due:
                    try:
                        await listener.send_changes(self.values)
                    except (ConnectionError, RuntimeError):  # disconnected
                        pass
                    except Exception as error:  # drop a listener that cannot be served
                        FAULTS.record("telling one listener", error)
                        self._listeners.discard(listener)

    async def _report_status(self) -> None:
        while True:
            facts: dict[str, Any] = {"at": f"{self._http[0]}:{self._http[1]}", "clients": len(self._listeners)}
            facts |= {"requests": self._requests, "refused": self._refused, "problem": self._problem}
            facts["dropped"] = self._server.dropped
            self._channel.send_facts(facts)
            await asyncio.sleep(STATUS_INTERVAL)


def _json(facts: dict[str, Any]) -> web.Response:
    return web.json_response(facts, headers=SECURITY_HEADERS)


async def _run(told: HelperChannel) -> None:
    await OscQueryServer(told).run()


if __name__ == "__main__":
    with asyncio.Runner(loop_factory=asyncio.SelectorEventLoop) as runner:  # the one that waits for sockets everywhere
        runner.run(_run(HelperChannel(sys.argv[1])))
