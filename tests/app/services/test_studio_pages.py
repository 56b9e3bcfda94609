"""Pages of the studio: a real show, a real web server, real WebSockets; and hostile pages."""

import asyncio
import io
import json
import os
import signal
import socket
import struct
import threading
import time
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any

import aiohttp
import numpy as np
import pytest
from PIL import Image

from live.app.services.score_stream import ScoreStream
from live.app.services.stage_stream import StageStream
from live.app.services.web_service import WebService, preview_files
from live.control.web.stage_subscriber import MAX_UNSENT_BYTES, MAX_WAITING_TEXTS, StageSubscriber
from live.document.preview import PreviewEngine
from live.show.loader import load_show
from live.show.patch.patch_reader import read_patch
from live.show.view.next_formations import NextFormations
from tests.app.services.test_document_service import PATCH, EditedShow
from tests.control.waiting import wait_for
from tests.show.patch.edited_night import write_patch_folder

KEY = "a-key-of-the-tests-4711"
DEADLINE = 120.0


class Studio(EditedShow):
    """A show with its web server; a thread draws its frames."""

    def __init__(self, patch: Path, osc: tuple[str, int] = ("127.0.0.1", 9)) -> None:
        """`osc`: where the page's commands are sent."""
        super().__init__(patch)
        self.next = NextFormations(self.show)
        score = ScoreStream(self.show, self.service)
        stage = StageStream(self.show, lambda: self.engine.view, score, lambda: 0, self.next.facts)
        self.web = WebService(
            ("127.0.0.1", 0), KEY, osc, self.show, self.clock, stage=stage,
            files=preview_files(self.loaded, None), inbox=self.inbox.add_queue(),
        )  # fmt: skip
        self.service.answer_listeners.append(self.web.answer)
        self.engine.patch_listeners.append(self.web.update_patch)
        self.web.start()
        self._stop = threading.Event()
        self.frames = 0
        self._thread = threading.Thread(target=self._draw)
        self._thread.start()

    def _draw(self) -> None:
        while not self._stop.wait(1 / 60):
            self.run(0.1 if self.frames % 5 == 0 else 0.0)
            self.next.frame()
            self.web.frame()
            self.watch.run_tasks()
            self.frames += 1

    def stop(self) -> None:
        self._stop.set()
        self._thread.join()
        self.web.stop()

    @property
    def facts(self) -> dict[str, Any]:
        return dict(self.web.status().get("stage") or {})

    def open(self, session: aiohttp.ClientSession, path: str = "/studio/stream", key: str = KEY, **values: Any) -> Any:
        url = f"http://127.0.0.1:{self.web.port}{path}"
        return session.ws_connect(url, headers={"Authorization": f"Bearer {key}"}, max_msg_size=1 << 24, **values)


@pytest.fixture
def studio(tmp_path: Path) -> Iterator[Studio]:
    made = Studio(write_patch_folder(tmp_path, PATCH))
    yield made
    made.stop()


class Page:
    """What a page has got, by kind."""

    def __init__(self, ws: aiohttp.ClientWebSocketResponse) -> None:
        self.ws = ws
        self.got: dict[str, list[Any]] = {}

    async def say(self, **said: Any) -> None:
        await self.ws.send_str(json.dumps(said))

    async def wait(self, kind: str, fits: Callable[[Any], bool] = lambda one: True) -> Any:
        """Return the next frame of a kind that fits; those before are in `got`."""
        async with asyncio.timeout(DEADLINE):
            while True:
                message = await self.ws.receive()
                if message.type is aiohttp.WSMsgType.BINARY:
                    name, told = str(message.data[0]), message.data
                else:
                    assert message.type is aiohttp.WSMsgType.TEXT, message
                    told = json.loads(message.data)
                    name = told["kind"]
                self.got.setdefault(name, []).append(told)
                if name == kind and fits(told):
                    return told


def with_pages(studio: Studio, count: int, act: Callable[..., Awaitable[None]]) -> None:
    async def run() -> None:
        async with aiohttp.ClientSession() as session:
            pages = [Page(await studio.open(session)) for _ in range(count)]
            await act(*pages)

    asyncio.run(asyncio.wait_for(run(), 3 * DEADLINE))


def test_a_page_sees_the_stage(studio: Studio) -> None:
    async def run() -> None:
        async with aiohttp.ClientSession() as session:
            with pytest.raises(aiohttp.WSServerHandshakeError):
                await studio.open(session, key="another-key-of-nobody")
            page = Page(await studio.open(session))
            await page.say(positions=30, joints=30, dancers=[2, 1])
            joints = await page.wait("2", lambda data: data[1] == 1)
            assert len(joints) == 8 + 2 * 22 * 6
            clock = await page.wait("clock")
            assert {"late_frames", "frame_ms", "elements"} <= set(clock)
            if "structure" not in page.got:
                await page.wait("structure")
            assert page.got["structure"][0]["score"]["name"] == "edited"
            assert page.got["dancers"][0]["ids"] == list(range(1, 11))
            later = Page(await studio.open(session))  # gets the structure that is there
            assert await later.wait("structure") == page.got["structure"][0]
            await later.say(positions=0, clock=0)

    asyncio.run(asyncio.wait_for(run(), 3 * DEADLINE))


@pytest.mark.long
def test_two_pages_edit_one_document(studio: Studio) -> None:
    async def act(ana: Page, bea: Page) -> None:
        for page, name in ((ana, "ana"), (bea, "bea")):
            await page.say(name=name)
            await page.wait("structure")
        await ana.say(do="set", at=["segment", 2, "formation"], value="line", id="a1")
        answer = await ana.wait("answer")
        assert (answer["id"], answer["revision"], answer["inverse"]["value"]) == ("a1", 1, "circle")
        change = await bea.wait("change")
        assert (change["by"], change["entries"][0]["value"]["formation"]) == ("ana", "line")
        await bea.say(do="set", at=["segment", 2, "formation"], value="nonsense", id=7)
        answer = await bea.wait("answer")
        assert (answer["id"], answer["refused"][0]["field"]) == (7, "segment.2.formation")
        await bea.say(do="set", at=["segment", 1, "measures"], value=3, base=1)
        assert (await bea.wait("answer"))["revision"] == 2
        await ana.say(do="undo", id="u")
        answer = await ana.wait("answer")
        assert (answer["id"], answer["revision"]) == ("u", 3)
        await ana.say(do="redo", id="r", by="nobody")
        assert (await ana.wait("answer"))["refused"]
        await bea.wait("change", lambda one: one["revision"] == 3)
        assert [one["what"] for one in bea.got["change"]] == ["edit", "edit", "undo"]
        assert len(bea.got["answer"]) == 2  # not those of the other page
        await bea.say(do="restore", revision=0)
        assert (await bea.wait("answer"))["revision"] == 4
        await ana.wait("structure", lambda one: one["revision"] == 4)

    with_pages(studio, 2, act)
    assert studio.path.read_text() == PATCH


@pytest.mark.long
def test_a_page_that_comes_later_gets_the_structure_and_the_changes_since(studio: Studio) -> None:
    async def run() -> None:
        async with aiohttp.ClientSession() as session:
            one = Page(await studio.open(session))
            await one.wait("structure")
            for number in range(70):  # more than are kept
                await one.say(do="set", at=["segment", 2, "measures"], value=2 + number % 5, id=number)
                if number % 20 == 10:
                    await one.wait("answer", lambda told, number=number: told["id"] == number)
            await one.wait("answer", lambda told: told["id"] == 69)
            last = studio.service.revision
            if one.got["change"][-1]["revision"] != last:
                await one.wait("change", lambda told: told["revision"] == last)
            assert len(one.got["structure"]) == 1
            other = Page(await studio.open(session))
            structure = await other.wait("structure")
            while structure["revision"] + len(other.got.get("change", [])) < last:
                await other.wait("change")
            assert structure["revision"] > 0

    asyncio.run(asyncio.wait_for(run(), 3 * DEADLINE))


@pytest.mark.long
def test_edits_together_are_one_for_every_page(studio: Studio) -> None:
    async def act(ana: Page, bea: Page) -> None:
        await ana.say(name="ana")
        await bea.wait("structure")
        edits = [
            {"do": "delete", "at": ["segment", 1]},
            {"do": "set", "at": ["segment", 1, "measures"], "value": 3},
        ]
        await ana.say(do="together", edits=edits, id=1)
        assert (await ana.wait("answer"))["revision"] == 1
        change = await bea.wait("change")
        assert [(one["from"], one["to"]) for one in change["shifts"]] == [(1, None)]
        assert [one["value"]["measures"] for one in change["entries"]] == [3]
        await ana.say(do="together", edits=[*edits, {"do": "set", "at": ["seed"], "value": "x"}], id=2)
        assert (await ana.wait("answer"))["refused"]
        await ana.say(do="together", edits=7, id=3)
        assert (await ana.wait("answer"))["refused"]
        await ana.say(do="undo", id=4)
        assert (await ana.wait("answer"))["revision"] == 2

    before = studio.loaded.path.read_bytes()
    with_pages(studio, 2, act)
    assert studio.loaded.path.read_bytes() == before


@pytest.mark.long
def test_a_long_edit_is_taken_journalled_and_replayed(studio: Studio) -> None:
    points = [[round(0.01 * number, 4), round(0.001 * number, 4)] for number in range(500)]
    edit = {"do": "insert", "at": ["segment"], "value": {"measure": 4, "measures": 2, "group": "ember", "path": points}}
    edit["value"]["path"] = [[x + 0.00012345678, z] for x, z in points]

    async def act(page: Page) -> None:
        await page.wait("structure")
        text = json.dumps({**edit, "id": "long"})
        assert len(text) > 10_000
        await page.ws.send_str(text)
        assert (await page.wait("answer"))["revision"] == 1
        await page.say(do="set", at=["name"], value="x" * 59_000, id="longer")
        assert "refused" in await page.wait("answer", lambda one: one["id"] == "longer")  # a name has 64 letters

    with_pages(studio, 1, act)
    assert len(read_patch(studio.path).segment[2].path or ()) == 500
    assert wait_for(lambda: studio.show.span.number > 6, 30.0)
    studio._stop.set()
    studio._thread.join()
    assert studio.replay_differences() == ()


@pytest.mark.long
def test_chosen_ways_and_doubts_come_from_the_preview_and_follow_the_document(studio: Studio) -> None:
    async def act(ana: Page, bea: Page) -> None:
        await ana.say(segment=2, name="ana", notes=True)
        ways = await ana.wait("ways")
        engine = PreviewEngine(load_show(studio.path))
        planned = engine.plan(8, 9).ways.transpose(1, 0, 2)
        assert ways["dancers"] == list(range(1, len(planned) + 1))
        assert np.abs(np.array(ways["ways"]) - planned).max() < 0.001
        assert (ways["segment"], ways["from"], ways["to"]) == (2, 8, 9)
        if "notes" not in ana.got:
            await ana.wait("notes")
        assert isinstance(ana.got["notes"][0]["notes"], list)
        await bea.say(do="change", at=["segment", 2], value={"formation": None, "path": [[0, 0], [9, 0]]}, id=1)
        await bea.wait("answer")
        again = await ana.wait("ways", lambda one: one["ways"] != ways["ways"])
        assert again["document"] == 1
        if len(ana.got["notes"]) < 2:
            await ana.wait("notes", lambda one: one != ana.got["notes"][0])
        assert any("m to go" in one["what"] for one in ana.got["notes"][-1]["notes"])
        await ana.say(segment=99)
        assert "there is no segment 99" in (await ana.wait("ways"))["refused"][0]["what"]
        await ana.say(measures=[2, 3])
        assert (await ana.wait("ways"))["from"] == 2
        assert "ways" not in bea.got

    with_pages(studio, 2, act)


@pytest.mark.long
def test_pages_see_who_looks(studio: Studio) -> None:
    async def act(ana: Page, bea: Page) -> None:
        await ana.say(name="ana", segment=1, dancers=[3], selected={"sequence": [2, 4], "dancer": [3]})
        people = await bea.wait("people", lambda one: any(person["name"] for person in one["people"]))
        assert people["count"] == 2
        assert people["people"][1] == {"name": "ana", "selected": {"sequence": [2, 4], "dancer": [3]}}
        await ana.ws.close()
        assert (await bea.wait("people", lambda one: one["count"] == 1))["people"][0]["name"] == ""

    with_pages(studio, 2, act)


@pytest.mark.long
def test_page_gets_the_projected_picture_while_it_wants_it(studio: Studio) -> None:
    picture = np.zeros((90, 160, 3), np.uint8)
    picture[:45, :, 0], picture[45:, :, 2] = 200, 150

    async def act(ana: Page, bea: Page) -> None:
        await ana.wait("structure")
        assert not studio.web.wants_picture
        await ana.say(picture=4)
        while not studio.web.wants_picture:
            await asyncio.sleep(0.01)
        studio.web.put_picture(picture)
        assert not studio.web.wants_picture  # it is on its way
        frame = await ana.wait("4")
        assert struct.unpack_from("<BBHH", frame) == (4, 0, 160, 90)
        with Image.open(io.BytesIO(frame[8:])) as image:
            seen = np.asarray(image, np.float64)
        assert np.abs(seen[8:37] - (200, 0, 0)).mean() < 3.0
        assert np.abs(seen[53:82] - (0, 0, 150)).mean() < 3.0
        assert "4" not in bea.got
        await ana.say(picture=0)
        while studio.web.wants_picture:
            await asyncio.sleep(0.01)

    with_pages(studio, 2, act)


HOSTILE = (
    "", "{", "[]", "null", "5", '"x"', "[" * 5000, '{"do": 5}',
    '{"do": []}', '{"do": "set"}', '{"do": "burn", "at": ["seed"]}',
    '{"positions": 1e9}', '{"positions": "x"}', '{"positions": NaN}', '{"nonsense": 1}', '{"dancers": ["x"]}',
    '{"dancers": [0]}', '{"dancers": ' + json.dumps([1] * 451) + "}", '{"name": 5}', '{"name": "\\n"}',
    '{"name": "' + "x" * 65 + '"}', '{"segment": -1}', '{"segment": true}', '{"measures": [1]}',
    '{"measures": [1, "x"]}', '{"selected": [1]}', '{"selected": {"segment": 1}}', '{"selected": {"segment": [0]}}',
    '{"selected": {"<b>": [1]}}', '{"selected": {"segment": ' + json.dumps([1] * 451) + "}}",
    '{"selected": ' + json.dumps({f"list{number}": [1] for number in range(33)}) + "}",
    '{"notes": 1}', '{"do": "undo", "by": 5}', '{"do": "undo", "revision": "x"}', '{"do": "restore", "revision": -1}',
    '{"do": "set", "at": ["seed"], "value": 1, "id": []}', '{"do": "set", "at": ["seed"], "value": "\\ud800"}',
    '{"do": "set", "at": ["seed"], "value": ' + "[" * 900 + "]" * 900 + "}",
    '{"do": "set", "at": ["seed"], "value": NaN}',
    '{"do": "set", "at": ["seed"], "value": ' + "9" * 400 + "}", '{"do": "undo", "at": ["seed"]}', "\x00", "\ud7ff",
)  # fmt: skip
"""What is no message of a page, and edits that nobody can take."""


def test_hostile_pages_are_refused_and_the_show_goes_on(studio: Studio) -> None:
    async def act(bad: Page, good: Page) -> None:
        await good.wait("structure")
        for text in HOSTILE:
            await bad.ws.send_str(text)
            assert await next_refusal(bad), text
        await bad.ws.send_bytes(b"\x00\xff")
        assert await next_refusal(bad)
        for _ in range(3000):  # more than may wait for a page, in one burst
            await bad.say(positions=10)
        await bad.wait("refused", lambda one: "too many" in one["refused"])
        await bad.ws.send_str("x" * 100_000)
        while not bad.ws.closed:
            await bad.ws.receive(timeout=DEADLINE)
        await good.say(do="set", at=["seed"], value=7, id="still")
        assert (await good.wait("answer"))["revision"] == 1

    with_pages(studio, 2, act)
    before = studio.frames
    assert wait_for(lambda: studio.frames > before + 30, 10.0)


async def next_refusal(page: Page) -> bool:
    """Whether the next frame that answers a message refuses it."""
    async with asyncio.timeout(DEADLINE):
        while True:
            message = await page.ws.receive()
            if message.type is aiohttp.WSMsgType.TEXT:
                told = json.loads(message.data)
                if told["kind"] in ("refused", "answer"):
                    return "refused" in told


@pytest.mark.long
def test_a_page_that_does_not_read_gets_fewer_frames_and_the_latest_ones(studio: Studio) -> None:
    async def run() -> None:
        async with aiohttp.ClientSession() as session:
            quick = Page(await studio.open(session))
            slow = Page(await studio.open(session, heartbeat=None))
            await slow.say(positions=60, joints=60, clock=60)
            transport = slow.ws._response.connection.transport  # type: ignore[union-attr]
            transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            transport.pause_reading()
            async with asyncio.timeout(DEADLINE):
                while studio.facts.get("missed", 0) < 60:
                    await quick.wait("1")
            missed_at = quick.got["1"][-1]
            (tick,) = struct.unpack_from("<I", missed_at, 4)
            transport.resume_reading()
            frames = 0
            while True:  # what waited in the system's buffers, then the present
                frame = await slow.wait("1")
                frames += 1
                if struct.unpack_from("<I", frame, 4)[0] >= tick:
                    break
            assert frames < len(quick.got["1"]) - 10

    asyncio.run(asyncio.wait_for(run(), 3 * DEADLINE))


class Transport:
    """A connection of a page that reads, or does not."""

    unsent = 0
    aborted = False

    def get_write_buffer_size(self) -> int:
        return self.unsent

    def get_extra_info(self, name: str) -> None:
        return None

    def abort(self) -> None:
        self.aborted = True


class FakeRequest:
    def __init__(self) -> None:
        self.transport = Transport()


class FakeSocket:
    """A WebSocket that takes data when it may."""

    closed = False

    def __init__(self) -> None:
        self.sent: list[Any] = []
        self.may = asyncio.Event()
        self.may.set()

    async def send_bytes(self, data: bytes) -> None:
        await self.may.wait()
        self.sent.append(data)

    send_str = send_bytes


def test_of_each_kind_only_the_latest_frame_waits() -> None:
    async def run() -> None:
        ws, request = FakeSocket(), FakeRequest()
        page = StageSubscriber(ws, request)  # type: ignore[arg-type]
        sender = asyncio.get_running_loop().create_task(page.send())
        ws.may.clear()
        page.put_frame("positions", b"first")
        await asyncio.sleep(0)
        for number in range(100):
            page.put_frame("positions", b"%d" % number)
            page.put_frame("clock", f"{number}")
            page.put_text(f"change {number}")
        assert page.missed == 198
        ws.may.set()
        while len(ws.sent) < 103:
            await asyncio.sleep(0)
        assert [ws.sent[0], *ws.sent[-2:]] == [b"first", b"99", "99"]
        assert ws.sent[1:101] == [f"change {number}" for number in range(100)]
        request.transport.unsent = MAX_UNSENT_BYTES + 1
        page.put_frame("positions", b"late")
        assert page.missed == 199
        request.transport.unsent = 0
        ws.may.clear()
        for number in range(MAX_WAITING_TEXTS + 1):
            assert not request.transport.aborted
            page.put_text(f"{number}")
        assert request.transport.aborted  # it may come again
        sender.cancel()

    asyncio.run(run())


def test_rates_are_those_that_a_page_wants() -> None:
    page = StageSubscriber(FakeSocket(), FakeRequest())  # type: ignore[arg-type]
    assert page.choose({"positions": 10}) == ""
    assert 29 <= sum(page.is_due("positions", frame / 30) for frame in range(90)) <= 32
    assert not page.is_due("joints", 1.0)


@pytest.mark.long
def test_a_web_server_that_dies_is_replaced_and_pages_come_again(studio: Studio) -> None:
    async def run() -> None:
        async with aiohttp.ClientSession() as session:
            page = Page(await studio.open(session))
            await page.wait("structure")
            assert studio.web.pid is not None
            os.kill(studio.web.pid, signal.SIGKILL)
            end = time.monotonic() + DEADLINE
            while time.monotonic() < end:
                try:
                    again = Page(await studio.open(session))
                    await again.wait("structure")
                    await again.wait("1")
                    return
                except (aiohttp.ClientError, AssertionError):
                    await asyncio.sleep(0.05)
            raise AssertionError("no page came again")

    asyncio.run(asyncio.wait_for(run(), 3 * DEADLINE))
