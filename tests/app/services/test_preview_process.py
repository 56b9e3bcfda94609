"""The preview in a process of its own: asked by pages over real WebSockets, killed, replaced and ended."""

import asyncio
import contextlib
import json
import os
import select
import signal
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any

import aiohttp
import pytest

from live.app.services.web_service import PREVIEW_MODULE, WebService, preview_files
from live.clock.time_source import SystemClock
from live.control.web.preview_client import NICE, PreviewClient
from live.document.document_store import DocumentStore
from live.document.edit import Edit
from live.document.preview_answers import open_answers
from live.show.loader import LoadedShow, load_show
from tests.document.test_preview import TEXT

KEY = "a-key-of-the-tests-4711"
DEADLINE = 120.0


@pytest.fixture
def loaded(tmp_path: Path) -> LoadedShow:
    path = tmp_path / "show.toml"
    path.write_text(TEXT)
    return load_show(path)


class Answer:
    """Frames of one question; `ended` when the last one is there."""

    def __init__(self) -> None:
        self.frames: list[str | bytes] = []
        self.ended = asyncio.Event()
        self.begun = asyncio.Event()

    def put(self, frame: str | bytes) -> None:
        self.begun.set()
        if isinstance(frame, str) and json.loads(frame)["kind"] == "progress":
            return
        self.frames.append(frame)
        if isinstance(frame, str) and json.loads(frame)["kind"] in ("done", "refused", "replaced"):
            self.ended.set()

    @property
    def last(self) -> Any:
        return json.loads(self.frames[-1])


async def ask(client: PreviewClient, question: dict[str, Any], page: str = "a") -> Answer:
    answer = Answer()
    client.ask(page, question, answer.put)
    await asyncio.wait_for(answer.ended.wait(), DEADLINE)
    return answer


def with_client(loaded: LoadedShow, act: Callable[[PreviewClient], Awaitable[None]], **values: float) -> None:
    async def run() -> None:
        client = PreviewClient(PREVIEW_MODULE, preview_files(loaded, None), **values)
        task = asyncio.get_running_loop().create_task(client.run())
        try:
            await asyncio.wait_for(act(client), 3 * DEADLINE)
        finally:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)
            assert client.pid is None

    asyncio.run(run())


@pytest.mark.long
def test_it_answers_as_the_engine_here_and_at_low_priority(loaded: LoadedShow) -> None:
    tried = [{"do": "set", "at": ["group", 1, "colour"], "value": [0.1, 0.2, 0.3]}]
    question = {"id": 1, "from": 7, "to": 9, "positions": "samples", "with": tried}
    wanted = list(open_answers(loaded).answer(question))
    assert json.loads(wanted[-1])["kind"] == "done"

    async def act(client: PreviewClient) -> None:
        assert client.pid is None  # nobody has asked
        assert (await ask(client, question)).frames == wanted
        assert client.pid is not None
        assert os.getpriority(os.PRIO_PROCESS, client.pid) == min(os.getpriority(os.PRIO_PROCESS, 0) + NICE, 19)
        assert (client.starts, client.answered) == (1, 1)

    with_client(loaded, act)


@pytest.mark.long
def test_a_killed_process_is_replaced_and_the_question_told(loaded: LoadedShow) -> None:
    async def act(client: PreviewClient) -> None:
        far = Answer()
        client.ask("a", {"id": "far", "measure": 5000.0}, far.put)
        await asyncio.wait_for(far.begun.wait(), DEADLINE)  # it simulates
        assert client.pid is not None
        os.kill(client.pid, signal.SIGKILL)
        await asyncio.wait_for(far.ended.wait(), DEADLINE)
        assert far.last["id"] == "far"
        assert far.last["refused"] == [
            {"what": "the preview ended unexpectedly", "remedy": "ask again: another one is started"}
        ]
        assert (await ask(client, {"id": 2, "measure": 1.5})).last["kind"] == "done"
        os.kill(client.pid, signal.SIGKILL)  # while nobody asks: the next question does not notice
        os.waitid(os.P_PID, client.pid, os.WEXITED | os.WNOWAIT)
        assert (await ask(client, {"id": 3, "measure": 1.5})).last["kind"] == "done"
        assert client.starts == 3

    with_client(loaded, act)


@pytest.mark.long
def test_one_that_hangs_is_replaced(loaded: LoadedShow) -> None:
    async def act(client: PreviewClient) -> None:
        await ask(client, {"id": 1, "measure": 1.5})
        assert client.pid is not None
        os.kill(client.pid, signal.SIGSTOP)
        client._silence = 0.2
        assert "does not answer" in (await ask(client, {"id": 2, "measure": 1.5})).last["refused"][0]["what"]
        client._silence = DEADLINE
        assert (await ask(client, {"id": 3, "measure": 1.5})).last["kind"] == "done"

    with_client(loaded, act, silence=DEADLINE)


@pytest.mark.long
def test_a_newer_question_of_a_page_replaces_its_older_one_and_others_wait_for_their_turn(loaded: LoadedShow) -> None:
    async def act(client: PreviewClient) -> None:
        far, nearer, other = Answer(), Answer(), Answer()
        client.ask("a", {"id": "far", "measure": 9000.0}, far.put)
        await asyncio.wait_for(far.begun.wait(), DEADLINE)
        client.ask("b", {"id": "other", "measure": 2.0}, other.put)
        client.ask("a", {"id": "waits", "measure": 3.0}, nearer.put)
        assert far.last == {"kind": "replaced", "id": "far"}
        client.ask("a", {"id": "last", "measure": 4.0}, nearer.put)
        await asyncio.wait_for(asyncio.gather(other.ended.wait(), nearer.ended.wait()), DEADLINE)
        assert other.last["kind"] == "done"
        while json.loads(nearer.frames[-1]) != {"kind": "done", "id": "last", "document": 0}:
            nearer.ended.clear()
            await asyncio.wait_for(nearer.ended.wait(), DEADLINE)
        assert json.loads(nearer.frames[0]) == {"kind": "replaced", "id": "waits"}
        assert client.starts == 1

    with_client(loaded, act)


@pytest.mark.long
def test_it_ends_when_nobody_asks_and_comes_again(loaded: LoadedShow) -> None:
    async def act(client: PreviewClient) -> None:
        assert (await ask(client, {"measure": 1.5})).last["kind"] == "done"
        process = client._process
        assert process is not None
        client._idle = 0.05
        assert (await ask(client, {"measure": 1.5})).last["kind"] == "done"
        assert await asyncio.to_thread(process.wait, DEADLINE) is not None
        client._idle = DEADLINE
        assert (await ask(client, {"measure": 1.5})).last["kind"] == "done"
        assert client.starts == 2

    with_client(loaded, act)


def test_files_that_do_not_start_are_told_and_mended_ones_are_previewed(loaded: LoadedShow) -> None:
    async def act(client: PreviewClient) -> None:
        loaded.path.write_text("name = ")
        assert "refused" in (await ask(client, {"id": 1, "measure": 1.5})).last
        loaded.path.write_text(TEXT)
        assert (await ask(client, {"id": 2, "measure": 1.5})).last["kind"] == "done"
        DocumentStore(loaded.path).edit(Edit("set", ("segment", 2, "formation"), "line"))
        assert (await ask(client, {"id": 3, "measure": 1.5})).last == {"kind": "done", "id": 3, "document": 1}
        assert client.starts == 1

    with_client(loaded, act)


@pytest.fixture
def web(loaded: LoadedShow) -> Iterator[WebService]:
    """A web server whose show never draws a frame: the preview does not need one."""
    files = preview_files(loaded, None)
    service = WebService(("127.0.0.1", 0), KEY, ("127.0.0.1", 9), loaded.start(), SystemClock(), files=files)
    service.start()
    yield service
    service.stop()


def preview_page(session: aiohttp.ClientSession, service: WebService, key: str = KEY) -> Any:
    url = f"http://127.0.0.1:{service.port}/studio/preview"
    return session.ws_connect(url, headers={"Authorization": f"Bearer {key}"}, max_msg_size=1 << 24)


async def answer_of(page: aiohttp.ClientWebSocketResponse) -> list[str | bytes]:
    """Return the frames of the next answer."""
    frames: list[str | bytes] = []
    while True:
        message = await page.receive(timeout=DEADLINE)
        assert message.type in (aiohttp.WSMsgType.TEXT, aiohttp.WSMsgType.BINARY), message
        if message.type is aiohttp.WSMsgType.TEXT:
            kind = json.loads(message.data)["kind"]
            if kind == "progress":
                continue
            if kind in ("done", "refused", "replaced"):
                return [*frames, message.data]
        frames.append(message.data)


@pytest.mark.long
def test_pages_ask_over_the_web(web: WebService, loaded: LoadedShow) -> None:
    question = {"id": 1, "measure": 5.5, "joints": True}
    wanted = list(open_answers(loaded).answer(question))

    async def run() -> None:
        async with aiohttp.ClientSession() as session:
            with pytest.raises(aiohttp.WSServerHandshakeError):
                await preview_page(session, web, "another-key-of-nobody")
            async with preview_page(session, web) as one, preview_page(session, web) as other:
                await other.send_str(json.dumps(question | {"measure": 7000.0}))
                await other.close()  # leaves while its question is served: the others need not wait for it
                await one.send_str(json.dumps(question))
                assert await answer_of(one) == wanted
                deep = [f'{{"from": 1, "with": {"[" * depth}{"]" * depth}}}' for depth in range(880, 1000, 7)]
                for wrong in ("", "{", "[]", "5", "[" * 10_000, '{"from": "x"}', '{"x": 1}', *deep):
                    await one.send_str(wrong)
                    assert json.loads((await answer_of(one))[-1])["kind"] == "refused"
                await one.send_bytes(b"\x00")
                assert json.loads((await answer_of(one))[-1])["kind"] == "refused"
                for number in range(200):
                    await one.send_str(json.dumps(question | {"id": number}))
                told = [json.loads((await answer_of(one))[-1]) for _ in range(200)]
                assert any("too many" in one["refused"][0]["what"] for one in told if one["kind"] == "refused")
                assert any(one["kind"] == "replaced" for one in told)
                await one.send_str("x" * 100_000)
                assert (await one.receive(timeout=DEADLINE)).type is aiohttp.WSMsgType.CLOSE

    asyncio.run(asyncio.wait_for(run(), 3 * DEADLINE))


@pytest.mark.long
def test_the_preview_ends_with_the_web_server(web: WebService) -> None:
    children: list[int] = []

    async def run() -> None:
        async with aiohttp.ClientSession() as session, preview_page(session, web) as page:
            await page.send_str('{"measure": 1.5}')
            await answer_of(page)
            for child in Path(f"/proc/{web.pid}/task/{web.pid}/children").read_text().split():
                children.append(int(child))
            assert web.pid is not None
            os.kill(web.pid, signal.SIGKILL)

    asyncio.run(asyncio.wait_for(run(), DEADLINE))
    (child,) = children
    with contextlib.suppress(ProcessLookupError):  # it has ended already
        assert select.select([os.pidfd_open(child)], [], [], DEADLINE)[0]
