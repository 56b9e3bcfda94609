"""Pages that look at the stage: what each wants, and how often; a slow one gets fewer frames, never a queue."""

import json
from collections.abc import Callable, Sequence
from typing import Any, Final

from aiohttp import web

from live.base.fault_isolation import FAULTS

MOST_HZ: Final = 60.0
MAX_UNSENT_BYTES: Final = 1 << 15
"""Maximum unsent bytes of a page; one that is further behind misses frames."""
MAX_CHOSEN: Final = 450
KINDS: Final = {1: "positions", 2: "joints"}
"""Names of the kinds of binary frames."""
MAX_TEXT_BYTES: Final = 16_000_000


class StageSubscriber:
    """One page."""

    def __init__(self, ws: web.WebSocketResponse, request: web.BaseRequest) -> None:
        self.ws, self.request = ws, request
        self.hertz = {"positions": 30.0, "joints": 0.0, "clock": 10.0}
        """Frames of each kind that it wants in a second, at most."""
        self.joints: list[int] = []
        """Dancers whose joints it wants, from 1; empty: all."""
        self.due: dict[str, float] = {}
        self.missed = 0
        """Frames left out because it was slow."""

    def choose(self, text: str) -> str:
        """Take a message {"positions": Hz, "joints": Hz, "clock": Hz, "dancers": [numbers]}; return why it is
        refused, or an empty text."""
        try:
            said = json.loads(text)
        except (ValueError, RecursionError):
            return "an object expected"
        if not isinstance(said, dict) or not set(said) <= {*self.hertz, "dancers"}:
            return f"an object of {', '.join([*self.hertz, 'dancers'])} expected"
        chosen = said.pop("dancers", self.joints)
        if not isinstance(chosen, list) or len(chosen) > MAX_CHOSEN:
            return f"dancers: a list of at most {MAX_CHOSEN} numbers expected"
        if not all(type(each) is int and 1 <= each <= 65535 for each in chosen):
            return "dancers: numbers from 1 expected"
        if not all(type(rate) in (int, float) and 0 <= rate <= MOST_HZ for rate in said.values()):
            return f"0 to {MOST_HZ:g} frames a second expected"
        self.hertz |= {kind: float(rate) for kind, rate in said.items()}
        self.joints = sorted(set(chosen))
        return ""

    def is_due(self, kind: str, now: float) -> bool:
        """Whether a frame of a kind is due; it counts as sent."""
        rate = self.hertz.get(kind, MOST_HZ)
        if rate <= 0.0 or now < self.due.get(kind, 0.0):
            return False
        transport = self.request.transport
        if transport is None or transport.get_write_buffer_size() > MAX_UNSENT_BYTES:
            self.missed += 1
            return False
        self.due[kind] = max(self.due.get(kind, 0.0) + 1.0 / rate, now - 0.5 / rate)
        return True


class StageSubscribers:
    """All pages that look at the stage. Thread: the loop's."""

    def __init__(self, now: Callable[[], float]) -> None:
        """`now` [s] is the loop's time."""
        self._now = now
        self._all: set[StageSubscriber] = set()
        self._kept: dict[str, bytes] = {}  # the last structure and dancers, for pages that come later
        self._parts: dict[str, list[bytes]] = {}
        self.sent_bytes = 0

    def __len__(self) -> int:
        return len(self._all)

    @property
    def wants(self) -> dict[str, Any]:
        """What the show has to send: the number of pages, and the dancers whose joints somebody wants."""
        looking = [page for page in self._all if page.hertz["joints"] > 0.0]
        everybody = any(not page.joints for page in looking)
        chosen = sorted({each for page in looking for each in page.joints})
        joints = None if not looking else [] if everybody else chosen[:MAX_CHOSEN]
        return {"pages": len(self._all), "joints": joints}

    async def add(self, page: StageSubscriber) -> None:
        """Add a page and tell it what is known."""
        self._all.add(page)
        for text in self._kept.values():
            await self._send(page, text.decode())

    def remove(self, page: StageSubscriber) -> None:
        """Remove a page."""
        self._all.discard(page)

    async def take(self, packet: Sequence[Any]) -> None:
        """Pass a packet of the show on to the pages for which it is due."""
        if packet[0] == "frame":
            kind, data = KINDS.get(packet[1], ""), packet[2]
            for page in list(self._all):
                if page.is_due(kind, self._now()):
                    await self._send(page, data)
            return
        _, name, part, parts, data = packet
        pieces = self._parts.setdefault(name, [])
        if part != len(pieces):  # a part was lost: wait for the next text
            pieces.clear()
            if part:
                return
        pieces.append(data)
        if part + 1 < parts or sum(map(len, pieces)) > MAX_TEXT_BYTES:
            return
        text = b"".join(pieces)
        pieces.clear()
        if name in ("structure", "dancers"):
            self._kept[name] = text
        for page in list(self._all):
            if name != "clock" or page.is_due(name, self._now()):
                await self._send(page, text.decode())

    async def _send(self, page: StageSubscriber, data: bytes | str) -> None:
        try:
            if isinstance(data, str):
                await page.ws.send_str(data)
            else:
                await page.ws.send_bytes(data)
            self.sent_bytes += len(data)
        except (ConnectionError, RuntimeError):  # disconnected
            self.remove(page)
        except Exception as error:
            FAULTS.record("showing the stage to a page", error)
            self.remove(page)
