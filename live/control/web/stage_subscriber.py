"""A page that looks at the stage: what it wants, and how often; a slow one gets fewer frames, never a queue."""

import asyncio
import json
import socket
from collections import deque
from typing import Any, Final

from aiohttp import web

from live.control.audience.rate_limit import TokenBucket

MOST_HZ: Final = 60.0
MAX_UNSENT_BYTES: Final = 1 << 15
"""Maximum unsent bytes of a page; one that is further behind misses frames."""
SEND_BUFFER_BYTES: Final = 1 << 14
"""Size of the system's buffer for a page: what waits there is old."""
MAX_WAITING_TEXTS: Final = 256
"""A page that has so many texts to read that may not be left out is closed; it may come again."""
MAX_CHOSEN: Final = 450
MAX_NAME: Final = 64
MAX_LISTS: Final = 32
MAX_LIST_NAME: Final = 32
PER_SECOND: Final = 60.0
"""Messages per second that one page may send; more are refused."""
MAX_UNANSWERED: Final = 64
"""Edits of one page that may wait for their answers."""
CHOICES: Final = (
    "positions", "joints", "clock", "picture", "dancers", "name", "segment", "measures", "notes", "selected",
)  # fmt: skip


class StageSubscriber:
    """One page."""

    def __init__(self, ws: web.WebSocketResponse, request: web.BaseRequest) -> None:
        self.ws, self.request = ws, request
        self.limit = TokenBucket(PER_SECOND, PER_SECOND)
        self.hertz = {"positions": 30.0, "joints": 0.0, "clock": 10.0, "picture": 0.0}
        """Frames of each kind that it wants in a second, at most."""
        self.joints: list[int] = []
        """Dancers whose joints it wants, from 1; empty: all."""
        self.name = ""
        """Who looks."""
        self.segment: int | None = None
        self.measures: list[int] | None = None
        """The segment, or the first and last measure, whose ways it wants; both from 1."""
        self.selected: dict[str, list[int]] = {}
        """What its person has selected: numbers, from 1, by the list of the document, or `dancer`; others see it."""
        self.notes = False
        """Whether it wants the doubts about the document."""
        self.revision: int | None = None
        """The revision of the document that it knows; None: none yet."""
        self.unanswered = 0
        """Number of its edits that wait for an answer."""
        self.missed = 0
        """Frames left out because it was slow."""
        self._due: dict[str, float] = {}
        self._texts: deque[str] = deque()
        self._frames: dict[str, str | bytes] = {}  # the latest of each kind
        self._wake = asyncio.Event()
        if request.transport is not None and (sock := request.transport.get_extra_info("socket")) is not None:
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER_BYTES)

    def choose(self, said: dict[str, Any]) -> str:
        """Take what the page chooses; return why it is refused, or an empty text. See `live docs web`."""
        if not set(said) <= {*CHOICES}:
            return f"an object of {', '.join(CHOICES)} expected"
        dancers, name, notes = said.get("dancers", self.joints), said.get("name", self.name), said.get("notes")
        if not isinstance(dancers, list) or len(dancers) > MAX_CHOSEN or not all(_is_number(each) for each in dancers):
            return f"dancers: a list of at most {MAX_CHOSEN} numbers from 1 expected"
        hertz = {kind: said[kind] for kind in self.hertz if kind in said}
        if not all(type(rate) in (int, float) and 0 <= rate <= MOST_HZ for rate in hertz.values()):
            return f"0 to {MOST_HZ:g} frames a second expected"
        if not isinstance(name, str) or len(name) > MAX_NAME or not (name.isprintable()):
            return f"name: a text of at most {MAX_NAME} characters expected"
        if "notes" in said and not isinstance(notes, bool):
            return "notes: true or false expected"
        segment, measures = said.get("segment"), said.get("measures")
        if segment is not None and not _is_number(segment):
            return "segment: a number from 1, or null, expected"
        if measures is not None and not (
            isinstance(measures, list) and len(measures) == 2 and all(_is_number(each) for each in measures)
        ):
            return "measures: the first and the last one, or null, expected"
        selected = said.get("selected", self.selected)
        if not _is_selection(selected):
            return f"selected: lists of numbers from 1 by name expected, {MAX_CHOSEN} numbers at most"
        self.selected = selected
        self.hertz |= {kind: float(rate) for kind, rate in hertz.items()}
        self.joints, self.name = sorted(set(dancers)), name
        self.notes = self.notes if notes is None else notes
        if "segment" in said or "measures" in said:
            self.segment, self.measures = segment, None if segment is not None else measures
        return ""

    @property
    def person(self) -> dict[str, Any]:
        """What other pages see of it."""
        return {"name": self.name, "selected": self.selected}

    @property
    def question(self) -> dict[str, Any] | None:
        """What the preview is asked for its ways; None if it wants none."""
        plain = {"positions": "none", "notes": False}
        if self.segment is not None:
            return {"segment": self.segment, **plain}
        return None if self.measures is None else {"from": self.measures[0], "to": self.measures[1], **plain}

    def is_due(self, kind: str, now: float) -> bool:
        """Whether a frame of a kind is due; it counts as sent."""
        rate = self.hertz.get(kind, MOST_HZ)
        if rate <= 0.0 or now < self._due.get(kind, 0.0):
            return False
        self._due[kind] = max(self._due.get(kind, 0.0) + 1.0 / rate, now - 0.5 / rate)
        return True

    def put_frame(self, kind: str, data: str | bytes) -> None:
        """Send the latest state of a kind, instead of an earlier one that has not been sent."""
        transport = self.request.transport
        if isinstance(data, bytes) and (transport is None or transport.get_write_buffer_size() > MAX_UNSENT_BYTES):
            self.missed += 1  # the next one is newer
            return
        self.missed += self._frames.get(kind, data) != data
        self._frames[kind] = data
        self._wake.set()

    def put_text(self, text: str) -> None:
        """Send a text that may not be left out. A page that does not read them is closed."""
        if len(self._texts) >= MAX_WAITING_TEXTS:
            if self.request.transport is not None:
                self.request.transport.abort()
            return
        self._texts.append(text)
        self._wake.set()

    async def send(self) -> None:
        """Send what is there, until the page leaves."""
        while not self.ws.closed:
            await self._wake.wait()
            self._wake.clear()
            while self._texts or self._frames:
                data = self._texts.popleft() if self._texts else self._frames.pop(next(iter(self._frames)))
                try:
                    await (self.ws.send_str(data) if isinstance(data, str) else self.ws.send_bytes(data))
                except (ConnectionError, RuntimeError):  # disconnected
                    return


def read_object(text: Any) -> dict[str, Any] | None:
    """Return the object that a page sent as JSON; None for anything else."""
    try:
        found = json.loads(text)
    except (ValueError, TypeError, RecursionError):
        return None
    return found if isinstance(found, dict) else None


def _is_selection(value: object) -> bool:
    return (
        isinstance(value, dict)
        and all(name.isidentifier() and len(name) <= MAX_LIST_NAME for name in value)
        and all(isinstance(numbers, list) and all(map(_is_number, numbers)) for numbers in value.values())
        and sum(map(len, value.values())) <= MAX_CHOSEN
        and len(value) <= MAX_LISTS
    )


def _is_number(value: object) -> bool:
    return type(value) is int and 1 <= value <= 65535
