"""Web server process of the operator's page: HTTP for the page, a WebSocket for values in both directions.

The page is generated from the registry (`Surface`). Its changes are sent to the show's own OSC port, as from any other
program, where they are checked, ranked, counted and journalled. The page itself contains no data of the show. All other
requests need the key in a header that no other site's page can send: `Authorization: Bearer KEY`, or, for a browser's
WebSocket, the subprotocols `live.operator, live.key.KEY`.
"""

import asyncio
import json
import socket
import sys
from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any, Final

from aiohttp import WSMsgType, web

from live.base.fault_isolation import FAULTS
from live.base.system.channel import listening_socket_of
from live.control.audience.rate_limit import TokenBucket
from live.control.helper_process import HelperChannel
from live.control.osc.osc_codec import encode
from live.control.registry.control import ArgumentValue
from live.control.registry.registry import READABLE, READINGS, REGISTRY, Values
from live.control.registry.rejections import Rejection
from live.control.tls import server_context
from live.control.web.camera_pages import CAMERA_PATH, CameraPages
from live.control.web.http_protection import (
    HEARTBEAT,
    SECURITY_HEADERS,
    BoundedServer,
    FailedKeys,
    is_same_origin,
    page_headers,
    serve,
    serve_tls,
)
from live.control.web.preview_client import PreviewClient
from live.control.web.preview_pages import PreviewPages
from live.control.web.stage_subscribers import StageSubscribers
from live.control.web.studio_files import StudioFiles
from live.control.web.surface import make_surface
from live.control.web.task_guard import guarded, keep_task
from live.control.web.web_key import PROTOCOL, has_key, is_relayed

PAGE: Final = Path(__file__).with_name("web_page.html")
MOST_CLIENTS: Final = 32
MOST_BYTES: Final = 1024
"""Maximum bytes of a message from the page."""
UPDATE_INTERVAL: Final = 1 / 20
PER_SECOND: Final = 200.0
"""Messages per second that one page may send; more are refused."""
MAX_UNSENT_BYTES: Final = 1 << 15
"""Maximum unsent bytes of a page; one that is further behind gets the latest values later."""
STATUS_INTERVAL: Final = 1.0
STAGE_PATH: Final = "/studio/stream"
PREVIEW_PATH: Final = "/studio/preview"
STUDIO_HEARTBEAT: Final = 16.0
"""As `HEARTBEAT`, for the two: on a slow line a ping comes after what was sent before it [s]."""
MAX_STUDIO_BYTES: Final = 60_000
"""Maximum bytes of a message to the two."""


class Client:
    """One open page."""

    def __init__(self, ws: web.WebSocketResponse, request: web.BaseRequest) -> None:
        self.ws, self.request = ws, request
        self.pending: dict[str, None] = dict.fromkeys(READABLE)
        self.wants_join = False
        """Whether the page has to be told how phones join, as audience and as cameras."""
        self.limit = TokenBucket(PER_SECOND, PER_SECOND)


def _surface_json(facts: Mapping[str, Any]) -> dict[str, Any]:
    """Return the controls of the page for the name of the show, the names in it, and half its stage [m]."""
    surface = make_surface(REGISTRY, role="operator", names=facts["names"], reach=tuple(facts["half"]))
    readings = {reading.address: reading.name for reading in READINGS}
    pages = [asdict(page) for page in surface.pages]
    for widget in (widget for page in pages for widget in page["widgets"]):
        control, _ = REGISTRY.resolve(widget["address"])
        widget["words"] = "" if control is None else control.description
    return {"name": facts["name"], "pages": pages, "readings": readings}


class WebServer:
    """Server of one show's page. Thread: the loop's."""

    def __init__(self, channel: HelperChannel) -> None:
        """Create the server; a loop must be running."""
        plan = channel.plan
        self._channel, self._key, self._show = channel, str(plan["key"]).encode(), tuple(plan["osc"])
        self._hosts = tuple(str(host) for host in plan["hosts"])
        self._socket = channel.listening_socket()
        self._osc_socket = socket.socket(socket.AF_INET6 if ":" in self._show[0] else socket.AF_INET, socket.SOCK_DGRAM)
        self._osc_socket.setblocking(False)
        self._surface = _surface_json(plan)
        self._text = PAGE.read_text(encoding="utf-8")
        self._studio = StudioFiles()
        self.values = Values()
        self._join = ""
        self._clients: set[Client] = set()
        files = plan.get("preview") or {"module": ""}  # without them there is no preview
        self._preview = PreviewClient(str(files["module"]), dict(files))
        self._preview_pages = PreviewPages(self._preview)
        now = asyncio.get_running_loop().time
        self._stage = StageSubscribers(now, self._preview, channel.send, self._tell_show)
        self._sent = self._refused = 0
        self._ended = asyncio.Event()
        self._server = BoundedServer(self._answer)
        self._failed = FailedKeys(asyncio.get_running_loop().time)
        self._cameras = CameraPages(plan, self._key, self._failed, channel.send)
        self._camera = plan.get("camera")
        self._camera_hosts = (*self._hosts, *(self._camera["hosts"] if self._camera is not None else ()))
        self._camera_server = BoundedServer(self._answer_phone)

    async def run(self) -> None:
        """Serve until the show ends."""
        runner = await serve(self._server, self._socket)
        cameras = None
        if self._camera is not None:
            identity = server_context(*self._camera["certificate"])
            cameras = await serve_tls(self._camera_server, listening_socket_of(self._camera["https"]), identity)
        asyncio.get_running_loop().add_reader(self._channel.socket, guarded("the show's packets", self._receive))
        tasks = [
            keep_task("telling pages", self._stream),
            keep_task("the preview", self._preview.run),
            keep_task("the page's figures", self._report_status),
        ]
        await self._ended.wait()
        for task in tasks:
            task.cancel()
        self._preview.close()
        await asyncio.gather(*(client.ws.close() for client in list(self._clients)), return_exceptions=True)
        await self._cameras.close()
        if cameras is not None:
            cameras.close()
            await self._camera_server.shutdown(1.0)
        await runner.cleanup()

    def _receive(self) -> None:
        """Handle new values from the show."""
        for changes in self._channel.packets():
            if not isinstance(changes, dict):
                if changes[0] == "surface":
                    self._surface = _surface_json(changes[1])
                elif changes[0] == "join":
                    self._join = str(changes[1])
                    for client in self._clients:
                        client.wants_join = True
                elif changes[0] == "performers":
                    keep_task("telling phones", partial(self._cameras.set_performers, changes[1]))
                else:
                    self._stage.take(changes)
                continue
            self.values.update(changes)
            for client in self._clients:
                client.pending |= dict.fromkeys(changes)
        if self._channel.closed:
            self._ended.set()

    async def _answer(self, request: web.BaseRequest) -> web.StreamResponse:
        """Answer with the page for requests under an accepted name, and with all else only for requests
        with the key."""
        if not is_same_origin(request, self._hosts, host_checked=is_relayed(request, self._key)):
            return self._refuse(403)
        path = request.path
        known = ("/", "/surface.json", "/ws", STAGE_PATH, PREVIEW_PATH)
        if path not in known and path not in self._studio and path not in self._cameras:
            return self._refuse(404)
        if request.path == PREVIEW_PATH and not self._preview.module:
            return self._refuse(404)
        if request.method not in ("GET", "HEAD"):
            return self._refuse(405)
        if request.path == "/":
            headers = page_headers(self._text, request.headers["Host"].casefold())
            return web.Response(text=self._text, content_type="text/html", headers=headers)
        if path in self._studio:
            return self._studio.answer(request)
        if path in self._cameras:
            return await self._cameras.answer(request, self._server)
        if not has_key(request, self._key):
            self._refused += 1
            return await self._failed.answer(request)
        if request.path == "/surface.json":
            answer = web.json_response(self._surface, headers=SECURITY_HEADERS)
            answer.enable_compression()
            return answer
        return await self._open(request)

    async def _answer_phone(self, request: web.BaseRequest) -> web.StreamResponse:
        """Answer at the port for phones that are cameras: with the camera page and what belongs to it."""
        if not is_same_origin(request, self._camera_hosts):
            return self._refuse(403)
        if request.path == "/":
            return web.Response(status=302, headers={**SECURITY_HEADERS, "Location": CAMERA_PATH})
        if request.path not in self._cameras:
            return self._refuse(404)
        if request.method not in ("GET", "HEAD"):
            return self._refuse(405)
        return await self._cameras.answer(request, self._camera_server)

    def _refuse(self, status: int) -> web.Response:
        self._refused += 1
        return web.Response(status=status, headers=SECURITY_HEADERS)

    async def _open(self, request: web.BaseRequest) -> web.StreamResponse:
        if request.headers.get("Upgrade", "").casefold() != "websocket":
            return self._refuse(400)
        if len(self._clients) + len(self._stage) + len(self._preview_pages) >= MOST_CLIENTS:
            return self._refuse(503)
        most, heartbeat = (MOST_BYTES, HEARTBEAT) if request.path == "/ws" else (MAX_STUDIO_BYTES, STUDIO_HEARTBEAT)
        ws = web.WebSocketResponse(
            max_msg_size=most, heartbeat=heartbeat, compress=False, timeout=1.0, protocols=(PROTOCOL,)
        )
        await ws.prepare(request)
        self._server.release(request)
        if request.path == STAGE_PATH:
            await self._stage.open(ws, request)
            return ws
        if request.path == PREVIEW_PATH:
            self._refused += await self._preview_pages.open(ws)
            return ws
        client = Client(ws, request)
        client.wants_join = bool(self._join) or self._camera is not None
        self._clients.add(client)
        try:
            async for message in ws:
                why = self._handle_message(client, message.data) if message.type is WSMsgType.TEXT else "text expected"
                if why:
                    self._refused += 1
                    await ws.send_str(json.dumps({"refused": why}))
        except (ConnectionError, RuntimeError):  # disconnected meanwhile
            pass
        finally:
            self._clients.discard(client)
        return ws

    def _handle_message(self, client: Client, text: str) -> str:
        """Send a message {"address": …, "values": […]} to the show; return the reason of a refusal, or an
        empty string."""
        if not client.limit.try_take(asyncio.get_running_loop().time()):
            return "too many messages at once"
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
            self._osc_socket.sendto(encode(address, tuple(values)), self._show)
        except (OSError, ValueError, OverflowError) as error:
            return f"the show does not receive: {error}"
        self._sent += 1
        return ""

    async def _stream(self) -> None:
        while True:
            await asyncio.sleep(UPDATE_INTERVAL)
            for client in list(self._clients):
                if client.pending or client.wants_join:
                    try:
                        await self._send_values(client)
                    except (ConnectionError, RuntimeError):  # disconnected
                        pass
                    except Exception as error:  # drop a client that cannot be updated
                        FAULTS.record("telling one client", error)
                        self._clients.discard(client)

    async def _send_values(self, client: Client) -> None:
        """Send changed values: the first of a value that differs between groups; each of a named one."""
        transport = client.request.transport
        if transport is None or transport.get_write_buffer_size() > MAX_UNSENT_BYTES:
            return  # pings detect clients that are gone; the others do not wait
        due, client.pending = client.pending, {}
        told: dict[str, list[ArgumentValue]] = {}
        for address in due:
            control = REGISTRY.find(address)
            if control is not None and control.named:
                told |= {where: list(values) for where, values in self.values.messages(address) if where != address}
            elif rows := self.values.rows(address):
                told[address] = list(rows[0][1])
        news: dict[str, Any] = {"values": told} if told else {}
        if client.wants_join:
            news["join"], client.wants_join = self._join, False
            if self._camera is not None:
                news["camera"] = {name: str(self._camera[name]) for name in ("link", "code")}
        if news:
            await client.ws.send_str(json.dumps(news))

    def _tell_show(self) -> None:
        facts = {
            "pages": len(self._clients),
            "sent": self._sent,
            "refused": self._refused + self._stage.refused,
            "stage": self._stage.wants,
        }
        facts["preview"] = {
            "pages": len(self._preview_pages),
            "answered": self._preview.answered,
            "starts": self._preview.starts,
        }
        if self._camera is not None:
            facts["phones"] = self._cameras.facts()
        self._channel.send_facts(facts | {"wrong_keys": self._failed.count, "dropped": self._server.dropped})

    async def _report_status(self) -> None:
        while True:
            self._tell_show()
            await asyncio.sleep(STATUS_INTERVAL)


async def _run(told: HelperChannel) -> None:
    await WebServer(told).run()


if __name__ == "__main__":
    with asyncio.Runner(loop_factory=asyncio.SelectorEventLoop) as runner:  # the one that waits for sockets everywhere
        runner.run(_run(HelperChannel(sys.argv[1])))
