"""The page of the studio on which a show is begun or opened, before one runs."""

import asyncio
import json
import socket
from collections.abc import Callable
from typing import Any, Final

from live.base.errors import PersonError
from live.control.web.studio_server import Frames, StudioServer

START_PATH: Final = "/studio/start"
MAX_BYTES: Final = 4096
"""Maximum bytes of a message."""
Choose = Callable[[Any], str]
"""Takes what a page has chosen, returns the path of the show; PersonError refuses it. It may take long."""


class StartServer:
    """Serves until a show was chosen. Thread: the loop's; `choose` runs in another."""

    def __init__(self, listening: socket.socket, key: str, facts: dict[str, Any], choose: Choose) -> None:
        """`facts`: what a page can choose from, as values for JSON. A loop must be running."""
        self._choose = choose
        self._server = StudioServer(
            listening, key, lambda: {"start": facts}, START_PATH, self._take, max_bytes=MAX_BYTES
        )
        self._chosen: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        self._busy = False

    async def run(self) -> str:
        """Serve, and return the path of the show that was chosen."""
        await self._server.run_until(self._chosen)
        return self._chosen.result()

    async def _take(self, text: str) -> Frames:
        return [json.dumps(await self._answer(text))]

    async def _answer(self, text: str) -> dict[str, Any]:
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
