"""Pages of the studio for the document bench, in a process of their own: they look, edit and ask the preview.

Each line of the standard input is an order ({}: go on), {"look": pages, "edits": per second of each, "preview": bool}.
The answer is a line with what came since the last one: {"bytes", "frames", "accepted", "refused", "answers"}.
"""

import asyncio
import contextlib
import json
import os
import random
import sys
from typing import Any

import aiohttp


class Pages:
    """What the pages do, and what they have got."""

    def __init__(self, port: int, key: str) -> None:
        self._url, self._headers = f"http://127.0.0.1:{port}", {"Authorization": f"Bearer {key}"}
        self._tasks: list[asyncio.Task[None]] = []
        self._rng = random.Random(1)
        self.counts: dict[str, int] = {}

    def _count(self, what: str, number: int = 1) -> None:
        self.counts[what] = self.counts.get(what, 0) + number

    async def obey(self, order: dict[str, Any]) -> None:
        """End what they do, and begin what is asked."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        loop = asyncio.get_running_loop()
        self._tasks = [loop.create_task(self._look(order["edits"], page)) for page in range(order["look"])]
        if order["preview"]:
            self._tasks.append(loop.create_task(self._ask()))

    async def _look(self, edits: float, page: int) -> None:
        async with (
            aiohttp.ClientSession() as session,
            session.ws_connect(f"{self._url}/studio/stream", headers=self._headers, max_msg_size=1 << 24) as ws,
        ):
            await ws.send_str(json.dumps({"positions": 30, "joints": 30, "clock": 10, "name": f"page {page}"}))
            editing = asyncio.get_running_loop().create_task(self._edit(ws, edits)) if edits else None
            try:
                async for message in ws:
                    self._count("bytes", len(message.data) + 4)  # the frame's head has 2 to 4 bytes
                    if message.type is aiohttp.WSMsgType.BINARY:
                        self._count("frames")
                    elif (told := json.loads(message.data))["kind"] == "answer":
                        self._count("refused" if "refused" in told else "accepted")
            finally:
                if editing is not None:
                    editing.cancel()

    async def _edit(self, ws: aiohttp.ClientWebSocketResponse, per_second: float) -> None:
        while True:
            await asyncio.sleep(1.0 / per_second)
            formation = self._rng.choice(("circle", "grid", "line", "star:5"))
            at = ["segment", self._rng.randrange(1, 17), "formation"]
            await ws.send_str(json.dumps({"do": "set", "at": at, "value": formation}))

    async def _ask(self) -> None:
        async with (
            aiohttp.ClientSession() as session,
            session.ws_connect(f"{self._url}/studio/preview", headers=self._headers, max_msg_size=1 << 24) as ws,
        ):
            while True:
                first = self._rng.randrange(1, 13)
                path = [
                    [round(self._rng.uniform(-4.0, 4.0), 3), round(self._rng.uniform(-3.0, 3.0), 3)] for _ in range(3)
                ]
                edit = {"do": "change", "at": ["segment", 1], "value": {"formation": None, "path": path}}
                await ws.send_str(json.dumps({"from": first, "to": first + 3, "with": [edit]}))  # simulated anew
                async for message in ws:
                    kind = json.loads(message.data)["kind"] if message.type is aiohttp.WSMsgType.TEXT else ""
                    if kind in ("done", "refused"):
                        self._count("answers" if kind == "done" else "refused")
                        break


async def main() -> None:
    """Obey the orders until the input ends."""
    os.nice(10)  # pages are on other machines
    pages, loop = Pages(int(sys.argv[1]), sys.argv[2]), asyncio.get_running_loop()
    while line := await loop.run_in_executor(None, sys.stdin.readline):
        with contextlib.suppress(aiohttp.ClientError):
            if order := json.loads(line):
                await pages.obey(order)
        print(json.dumps(pages.counts), flush=True)
        pages.counts = {}


if __name__ == "__main__":
    asyncio.run(main())
