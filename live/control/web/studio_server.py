"""Web server of a page where no show runs, such as the studio: its files, facts of what there is to do, one WebSocket.

`/surface.json` has the facts; the WebSocket takes messages of pages and answers them. Keys, names and limits are those
of a show's page.
"""

import asyncio
import socket
from collections.abc import Awaitable, Callable
from typing import Any

from aiohttp import WSMsgType, web

from live.control.web.http_protection import (
    HEARTBEAT,
    SECURITY_HEADERS,
    BoundedServer,
    FailedKeys,
    is_same_origin,
    serve,
)
from live.control.web.studio_files import StudioFiles
from live.control.web.web_key import PROTOCOL, has_key

Frames = list[str | bytes]
MAX_PAGES = 8


class StudioServer:
    """Serves until its caller has enough. Thread: the loop's."""

    def __init__(
        self,
        listening: socket.socket,
        key: str,
        facts: Callable[[], dict[str, Any]],
        path: str,
        take: Callable[[str], Awaitable[Frames]],
        *,
        max_bytes: int,
        files: StudioFiles | None = None,
    ) -> None:
        """`facts`: of `/surface.json`; `path` of the WebSocket, whose messages of at most `max_bytes` go to `take`,
        which returns the frames of the answer; `files`: of the page, by default the studio's. A loop must be running.
        """
        self._socket, self._key, self._facts = listening, key.encode(), facts
        self._path, self._take, self._max_bytes = path, take, max_bytes
        self._files = StudioFiles() if files is None else files
        self._failed = FailedKeys(asyncio.get_running_loop().time)
        self._server = BoundedServer(self._answer)
        self._pages: set[web.WebSocketResponse] = set()

    async def run_until(self, end: Awaitable[Any]) -> None:
        """Serve until `end` is there."""
        runner = await serve(self._server, self._socket)
        try:
            await end
        finally:
            await asyncio.gather(*(ws.close() for ws in list(self._pages)), return_exceptions=True)
            await runner.cleanup()

    async def _answer(self, request: web.BaseRequest) -> web.StreamResponse:
        if not is_same_origin(request):
            return web.Response(status=403, headers=SECURITY_HEADERS)
        if request.path == "/" and request.method in ("GET", "HEAD"):
            return web.Response(status=302, headers={**SECURITY_HEADERS, "Location": self._files.root})
        if request.path not in ("/surface.json", self._path) and request.path not in self._files:
            return web.Response(status=404, headers=SECURITY_HEADERS)
        if request.method not in ("GET", "HEAD"):
            return web.Response(status=405, headers=SECURITY_HEADERS)
        if request.path in self._files:
            return self._files.answer(request)
        if not has_key(request, self._key):
            return await self._failed.answer(request)
        if request.path == "/surface.json":
            return web.json_response(self._facts(), headers=SECURITY_HEADERS)
        return await self._open(request)

    async def _open(self, request: web.BaseRequest) -> web.StreamResponse:
        if request.headers.get("Upgrade", "").casefold() != "websocket":
            return web.Response(status=400, headers=SECURITY_HEADERS)
        if len(self._pages) >= MAX_PAGES:
            return web.Response(status=503, headers=SECURITY_HEADERS)
        ws = web.WebSocketResponse(
            max_msg_size=self._max_bytes, heartbeat=HEARTBEAT, compress=False, protocols=(PROTOCOL,)
        )
        await ws.prepare(request)
        self._server.release(request)
        self._pages.add(ws)
        try:
            async for message in ws:
                for frame in await self._take(message.data if message.type is WSMsgType.TEXT else ""):
                    await (ws.send_str(frame) if isinstance(frame, str) else ws.send_bytes(frame))
        except (ConnectionError, RuntimeError):  # disconnected meanwhile
            pass
        finally:
            self._pages.discard(ws)
        return ws
