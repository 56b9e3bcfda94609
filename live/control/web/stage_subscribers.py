"""All pages that look at the stage: frames of the show for each, edits of each for the show, and who looks."""

import io
import json
import secrets
import struct
from collections.abc import Callable, Sequence
from typing import Any, Final

from aiohttp import WSMsgType, web
from PIL import Image

from live.control.web.preview_client import PreviewClient
from live.control.web.stage_subscriber import MAX_CHOSEN, MAX_UNANSWERED, StageSubscriber, read_object
from live.control.web.task_guard import keep_task

PICTURE: Final = 4
"""Kind of the binary frame with the projected picture."""
PICTURE_HEAD: Final = struct.Struct("<BBHHH")
JPEG_QUALITY: Final = 72
KINDS: Final = {1: "positions", 2: "joints"}
"""Names of the kinds of binary frames."""
MAX_TEXT_BYTES: Final = 16_000_000
MAX_KEPT_CHANGES: Final = 64
"""After so many changes the whole structure is asked for, for pages that come later."""
EDIT_KEYS: Final = frozenset(("do", "at", "value", "id", "by", "base", "exact", "edits"))
RETURN_KEYS: Final = frozenset(("do", "id", "by", "revision"))
RETURNS: Final = ("undo", "redo", "restore")
NOTES: Final = "notes"
MAX_EDIT_BYTES: Final = 60_000
"""Maximum length of an edit; a packet has 64 KiB."""
TOO_MANY: Final = "too many messages at once"
"""A page is told this once for all messages of a burst: a queue of answers would close it."""
ANSWER_S: Final = 60.0
"""Longest wait for the answer to an edit [s]."""


class StageSubscribers:
    """Pages of one show. Thread: the loop's."""

    def __init__(
        self, now: Callable[[], float], preview: PreviewClient, send: Callable[[object], bool],
        tell: Callable[[], None],
    ) -> None:  # fmt: skip
        """`now` [s] is the loop's time; `send` passes a packet on to the show, and returns whether there was room;
        `tell` is called when `wants` has changed."""
        self._now, self._preview, self._send, self._tell_show = now, preview, send, tell
        self._told: dict[str, Any] = {}
        self._all: set[StageSubscriber] = set()
        self._structure: str | None = None
        self._changes: list[str] = []  # since the structure
        self._revision = 0
        self._dancers: str | None = None
        self._pads: dict[str, str] = {}  # the last texts about pads
        self._notes: str | None = None
        self._people = ""
        self._wish = 0  # changes when the whole structure is wanted
        self._parts: dict[str, list[bytes]] = {}
        self._edits: dict[int, tuple[StageSubscriber, Any, float]] = {}  # that wait: page, the page's id, since when
        self._edit = secrets.randbits(40)  # answers to edits of a process before this one are nobody's
        self._missed = 0  # of pages that have left
        self.refused = 0
        """Messages that were refused."""

    def __len__(self) -> int:
        return len(self._all)

    @property
    def wants(self) -> dict[str, Any]:
        """What the show has to send: the number of pages, the dancers whose joints somebody wants, and a number that is
        another one when the whole structure is wanted; whether somebody wants the projected picture; also the frames
        that slow pages missed."""
        looking = [page for page in self._all if page.hertz["joints"] > 0.0]
        everybody = any(not page.joints for page in looking)
        chosen = sorted({each for page in looking for each in page.joints})
        joints = None if not looking else [] if everybody else chosen[:MAX_CHOSEN]
        missed = self._missed + sum(page.missed for page in self._all)
        picture = any(page.hertz["picture"] > 0.0 for page in self._all)
        told = {"pages": len(self._all), "joints": joints, "structure": self._wish, "missed": missed}
        return {**told, "picture": picture}

    # -- pages -------------------------------------------------------------------------------------------------------

    async def open(self, ws: web.WebSocketResponse, request: web.BaseRequest) -> None:
        """Show the stage to a page until it leaves."""
        page = StageSubscriber(ws, request)
        sender = keep_task("showing the stage to a page", page.send)
        self.add(page)
        try:
            async for message in ws:
                why = self._take_message(page, message.data if message.type is WSMsgType.TEXT else None)
                if why:
                    self.refused += 1
                    told = json.dumps({"kind": "refused", "refused": why})
                    page.put_frame("refused", told) if why == TOO_MANY else page.put_text(told)
        except (ConnectionError, RuntimeError):  # disconnected meanwhile
            pass
        finally:
            self.remove(page)
            sender.cancel()

    def add(self, page: StageSubscriber) -> None:
        """Add a page and tell it what is known."""
        if not self._all or self._structure is None:
            self._structure = None
            self._wish += 1
        self._all.add(page)
        if self._structure is not None:
            for text in (self._structure, *self._changes):
                page.put_text(text)
            page.revision = self._revision
        if self._dancers is not None:
            page.put_text(self._dancers)
        for name, text in self._pads.items():
            page.put_frame(name, text)
        self._tell_people()
        self._tell()

    def remove(self, page: StageSubscriber) -> None:
        """Remove a page."""
        self._all.discard(page)
        self._missed += page.missed
        self._preview.forget(page)
        self._tell_people()
        self._tell()

    def _tell(self) -> None:
        if self.wants != self._told:
            self._told = self.wants
            self._tell_show()

    def _tell_people(self) -> None:
        people = sorted((page.person for page in self._all), key=lambda one: str(one["name"]))
        text = json.dumps({"kind": "people", "count": len(people), "people": people})
        if text != self._people:
            self._people = text
            for page in self._all:
                page.put_frame("people", text)

    def _take_message(self, page: StageSubscriber, text: str | None) -> str:
        """Take a message of a page; return why it is refused, or an empty text."""
        if not page.limit.try_take(self._now()):
            return TOO_MANY
        said = read_object(text)
        if said is None:
            return "an object expected"
        if "do" in said:
            return self._take_edit(page, said)
        before = page.question, page.notes, page.person
        if why := page.choose(said):
            return why
        if page.question != before[0] or "segment" in said or "measures" in said:
            self._ask_ways(page)
        if page.notes and not before[1]:
            if self._notes is not None:
                page.put_frame(NOTES, self._notes)
            self._ask_notes()
        if page.person != before[2]:
            self._tell_people()
        self._tell()
        return ""

    # -- edits -------------------------------------------------------------------------------------------------------

    def _take_edit(self, page: StageSubscriber, said: dict[str, Any]) -> str:
        """Pass an edit on to the show, which answers it; return why it is refused here, or an empty text."""
        word = said["do"]
        name = said.get("id")
        if not set(said) <= (RETURN_KEYS if word in RETURNS else EDIT_KEYS) or not isinstance(word, str):
            return f"an edit is an object of {', '.join(sorted(EDIT_KEYS))}"
        by = said.setdefault("by", page.name)
        if not isinstance(by, str) or len(by) > 64 or not isinstance(name, str | int | None):
            return "id: a text or number, by: a text of at most 64 characters expected"
        if page.unanswered >= MAX_UNANSWERED:
            return f"{MAX_UNANSWERED} edits wait for their answers"
        self._drop_unanswered()
        self._edit += 1
        try:
            packet: list[Any] = ["edit", self._edit, json.dumps(said, ensure_ascii=False)]
            if len(packet[2].encode()) > MAX_EDIT_BYTES:
                return f"an edit has at most {MAX_EDIT_BYTES} bytes"
        except (ValueError, RecursionError):
            return "not a text in UTF-8, or its brackets are nested too deep"
        if word in RETURNS:
            revision = said.get("revision", 0)
            if type(revision) is not int or not 0 <= revision <= 100_000_000:
                return "revision: a number of the history expected"
            packet = [word, self._edit, by, revision]
        if not self._send(packet):
            return "the show is busy: send the edit again"
        self._edits[self._edit] = page, name, self._now()
        page.unanswered += 1
        return ""

    def _answer(self, number: int, answer: dict[str, Any]) -> None:
        """Pass the show's answer on to the page that sent the edit."""
        if number not in self._edits:
            return
        page, name, _ = self._edits.pop(number)
        page.unanswered -= 1
        if page in self._all:
            page.put_text(json.dumps({"kind": "answer", **answer, "id": name}))

    def _drop_unanswered(self) -> None:
        """Refuse the edits that the show has not answered for too long."""
        for number, (_, _, since) in list(self._edits.items()):
            if self._now() < since + ANSWER_S:
                return  # they are in order
            self._answer(
                number, {"refused": [{"what": "the show did not answer", "remedy": "look, and send it again"}]}
            )

    # -- the preview's -----------------------------------------------------------------------------------------------

    def _ask_ways(self, page: StageSubscriber) -> None:
        question = page.question
        if question is None:
            self._preview.forget(page)
            return
        chosen = {"segment": page.segment, "measures": page.measures}

        def deliver(frame: str | bytes) -> None:
            told = read_object(frame)
            if told is not None and told.get("kind") in ("ways", "refused") and page in self._all:
                page.put_frame("ways", json.dumps({**told, "kind": "ways", **chosen}))

        self._preview.ask(page, question, deliver)

    def _ask_notes(self) -> None:
        def deliver(frame: str | bytes) -> None:
            told = read_object(frame)
            if told is None or told.get("kind") != NOTES:
                return
            text = json.dumps({"kind": NOTES, "document": told.get("document"), "notes": told.get("notes")})
            if text != self._notes:
                self._notes = text
                for page in self._all:
                    if page.notes:
                        page.put_frame(NOTES, text)

        self._preview.ask(NOTES, {"positions": "none", "ways": False}, deliver)

    def _ask_again(self) -> None:
        """Ask the preview what it says of the changed document."""
        if any(page.notes for page in self._all):
            self._ask_notes()
        for page in self._all:
            if page.question is not None:
                self._ask_ways(page)

    # -- the show's --------------------------------------------------------------------------------------------------

    def take(self, packet: Sequence[Any]) -> None:
        """Pass a packet of the show on to the pages for which it is due."""
        if packet[0] == "frame":
            kind, data = KINDS.get(packet[1], ""), packet[2]
            for page in self._all:
                if page.is_due(kind, self._now()):
                    page.put_frame(kind, data)
            return
        _, name, number, part, parts, data = packet
        pieces = self._parts.setdefault(name, [])
        if part != len(pieces):  # a part was lost: wait for the next text
            pieces.clear()
            if part:
                return
        pieces.append(data)
        if part + 1 < parts or sum(map(len, pieces)) > MAX_TEXT_BYTES:
            return
        data = b"".join(pieces)
        pieces.clear()
        if name == "picture":
            self._take_picture(data)
        else:
            self._take_text(name, number, data.decode())

    def _take_picture(self, data: bytes) -> None:
        """Pass the projected picture on as a JPEG; `data`: u16 width, u16 height, RGB."""
        width, height = struct.unpack_from("<HH", data)
        if width * height * 3 + 4 != len(data):
            return  # a part of another one
        compressed = io.BytesIO()
        Image.frombuffer("RGB", (width, height), data[4:]).save(compressed, "JPEG", quality=JPEG_QUALITY)
        frame = PICTURE_HEAD.pack(PICTURE, 0, width, height, 0) + compressed.getvalue()
        for page in self._all:
            if page.is_due("picture", self._now()):
                page.put_frame("picture", frame)

    def _take_text(self, name: str, number: int, text: str) -> None:
        """Take a whole text of the show; `number`: the revision, or of an answer that of the edit."""
        match name:
            case "clock":
                for page in self._all:
                    if page.is_due(name, self._now()):
                        page.put_frame(name, text)
            case "answer":
                self._answer(number, read_object(text) or {})
            case "pads" | "launches":
                self._take_pads(name, text)
            case "dancers":
                self._dancers = text
                for page in self._all:
                    page.put_text(text)
            case "structure":
                self._take_structure(number, text)
            case "change":
                self._take_change(number, text)
            case "replacement":
                for page in self._all:
                    page.revision = None
                    page.put_text(text)

    def _take_pads(self, name: str, text: str) -> None:
        self._pads[name] = text
        for page in self._all:
            page.put_frame(name, text)

    def _take_structure(self, revision: int, text: str) -> None:
        self._structure, self._changes, self._revision = text, [], revision
        for page in self._all:
            if page.revision != revision:
                page.revision = revision
                page.put_text(text)
        self._ask_again()

    def _take_change(self, revision: int, text: str) -> None:
        self._changes.append(text)
        self._revision = revision
        for page in self._all:
            if page.revision == revision - 1:
                page.revision = revision
                page.put_text(text)
        if len(self._changes) > MAX_KEPT_CHANGES:
            self._structure = None
            self._wish += 1
            self._tell()
        self._ask_again()
