"""Web server of the studio before a show runs: the page on which one is begun or opened.

It serves the studio's files; `/surface.json` says what there is to choose from, and a WebSocket takes the choice. Keys,
names and limits are those of a show's page.
"""

import asyncio
import json
import socket
from collections.abc import Callable
from typing import Any, Final

from aiohttp import WSMsgType, web

from live.base.errors import PersonError
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

START_PATH: Final = "/studio/start"
MAX_PAGES: Final = 8
MAX_BYTES: Final = 4096
"""Maximum bytes of a message."""
Choose = Callable[[Any], str]
"""Takes what a page has chosen, returns the path of the show; PersonError refuses it. It may take long."""


class StartServer:
    """Serves until a show was chosen. Thread: the loop's; `choose` runs in another."""

    def __init__(self, listening: socket.socket, key: str, facts: dict[str, Any], choose: Choose) -> None:
        """`facts`: what a page can choose from, as values for JSON. A loop must be running."""
        self._socket, self._key, self._choose = listening, key.encode(), choose
        self._facts = facts
        self._files = StudioFiles()
        self._failed = FailedKeys(asyncio.get_running_loop().time)
        self._server = BoundedServer(self._answer)
        self._pages: set[web.WebSocketResponse] = set()
        self._chosen: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        self._busy = False

    async def run(self) -> str:
        """Serve, and return the path of the show that was chosen."""
        runner = await serve(self._server, self._socket)
        try:
            return await self._chosen
        finally:
            await asyncio.gather(*(ws.close() for ws in list(self._pages)), return_exceptions=True)
            await runner.cleanup()

    async def _answer(self, request: web.BaseRequest) -> web.StreamResponse:
        if not is_same_origin(request):
            return web.Response(status=403, headers=SECURITY_HEADERS)
        if request.path == "/" and request.method in ("GET", "HEAD"):
            return web.Response(status=302, headers={**SECURITY_HEADERS, "Location": "/studio"})
        if request.path not in ("/surface.json", START_PATH) and request.path not in self._files:
            return web.Response(status=404, headers=SECURITY_HEADERS)
        if request.method not in ("GET", "HEAD"):
            return web.Response(status=405, headers=SECURITY_HEADERS)
        if request.path in self._files:
            return self._files.answer(request)
        if not has_key(request, self._key):
            return await self._failed.answer(request)
        if request.path == "/surface.json":
            return web.json_response({"start": self._facts}, headers=SECURITY_HEADERS)
        return await self._open(request)

    async def _open(self, request: web.BaseRequest) -> web.StreamResponse:
        if request.headers.get("Upgrade", "").casefold() != "websocket":
            return web.Response(status=400, headers=SECURITY_HEADERS)
        if len(self._pages) >= MAX_PAGES:
            return web.Response(status=503, headers=SECURITY_HEADERS)
        ws = web.WebSocketResponse(max_msg_size=MAX_BYTES, heartbeat=HEARTBEAT, compress=False, protocols=(PROTOCOL,))
        await ws.prepare(request)
        self._server.release(request)
        self._pages.add(ws)
        try:
            async for message in ws:
                await ws.send_str(json.dumps(await self._take(message.data if message.type is WSMsgType.TEXT else "")))
        except (ConnectionError, RuntimeError):  # disconnected meanwhile
            pass
        finally:
            self._pages.discard(ws)
        return ws

    async def _take(self, text: str) -> dict[str, Any]:
        """Return the answer to a message of a page."""
        if self._busy or self._chosen.done():
            return {"kind": "refused", "refused": [{"what": "another show is being made", "remedy": ""}]}
        self._busy = True
        try:
            path = await asyncio.to_thread(self._choose, json.loads(text))
        except (ValueError, RecursionError):
            return {"kind": "refused", "refused": [{"what": "an object expected", "remedy": ""}]}
        except PersonError as error:
            return {"kind": "refused", "refused": [{"what": error.message, "remedy": error.remedy or ""}]}
        finally:
            self._busy = False
        asyncio.get_running_loop().call_soon(self._chosen.set_result, path)
        return {"kind": "made", "show": path}
