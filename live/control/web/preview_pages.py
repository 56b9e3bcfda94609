"""Pages that ask the preview: each has one question at a time, and gets its answer as fast as it reads."""

import asyncio
import json
from typing import Any, Final

from aiohttp import WSMsgType, web

from live.control.audience.rate_limit import TokenBucket
from live.control.web.preview_client import PreviewClient, refused_text
from live.control.web.task_guard import keep_task

PER_SECOND: Final = 60.0
"""Questions per second of one page; more are refused. It scrubs with the pictures of a monitor."""
MAX_UNREAD_BYTES: Final = 4_000_000
"""A page that has not read so much of its answers may not ask more."""


class PreviewPage:
    """One page, and what it has not read yet."""

    def __init__(self, ws: web.WebSocketResponse) -> None:
        self.ws = ws
        self.limit = TokenBucket(PER_SECOND, PER_SECOND)
        self.unread_bytes = 0
        self._frames: asyncio.Queue[str | bytes] = asyncio.Queue()

    def put(self, frame: str | bytes) -> None:
        """Add a frame that is to be sent."""
        self.unread_bytes += len(frame)
        self._frames.put_nowait(frame)

    async def send(self) -> None:
        """Send the frames until the page leaves."""
        while not self.ws.closed:
            frame = await self._frames.get()
            try:
                await (self.ws.send_str(frame) if isinstance(frame, str) else self.ws.send_bytes(frame))
            except (ConnectionError, RuntimeError):  # disconnected
                return
            self.unread_bytes -= len(frame)


class PreviewPages:
    """All pages that ask the preview. Thread: the loop's."""

    def __init__(self, client: PreviewClient) -> None:
        self._client = client
        self._count = 0

    def __len__(self) -> int:
        return self._count

    async def open(self, ws: web.WebSocketResponse) -> int:
        """Serve a page until it leaves; return how many of its messages were refused."""
        page, refused = PreviewPage(ws), 0
        self._count += 1
        sender = keep_task("answers of the preview", page.send)
        try:
            async for message in ws:
                question = _question(message.data) if message.type is WSMsgType.TEXT else None
                why = self._refusal(page, question)
                if question is None or why is not None:
                    refused += 1
                    page.put(refused_text(question, *(why or ("", ""))))
                else:
                    self._client.ask(page, question, page.put)
        except (ConnectionError, RuntimeError):  # disconnected meanwhile
            pass
        finally:
            self._count -= 1
            self._client.forget(page)
            sender.cancel()
        return refused

    def _refusal(self, page: PreviewPage, question: Any) -> tuple[str, str] | None:
        """Return why a page may not ask this now, and what to do."""
        if not page.limit.try_take(asyncio.get_running_loop().time()):
            return "too many questions at once", f"{PER_SECOND:g} a second at most"
        if question is None:
            return "an object expected", '{"id": 1, "from": 57, "to": 60}'
        if page.unread_bytes > MAX_UNREAD_BYTES:
            return "the former answers have not been read", "read them first"
        return None


def _question(text: str) -> dict[str, Any] | None:
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) else None
