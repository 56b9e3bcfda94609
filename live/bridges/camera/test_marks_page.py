"""The page of `live calibrate camera`: a film's floor is clicked in a browser; who may ask, and for what."""

import asyncio
import io
import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import aiohttp
import numpy as np
import pytest
from PIL import Image

from live.base.errors import PersonError
from live.bridges.camera.floor_marks import Clicks, FloorMarks
from live.bridges.camera.marks_page import ROOT, WORD_PATH, MarksPage
from live.bridges.camera.stage_camera import StageCamera
from live.bridges.camera.test_floor_marks import (
    MARKS,
    MARKS_TEXT,
    SIZE,
    VIEW,
    check_same_camera,
    floor_picture,
    mark_places,
    venue_view,
    write_floor_film,
)
from live.control.camera.camera_plan import CameraAddress
from live.control.camera.frame_source import FrameSource
from live.motion.capture.camera_view import CameraView
from tests.control.waiting import BUSY
from tests.end_to_end.browser import browser, needs_browser
from tests.end_to_end.studio.test_studio_accessibility import AXE

KEY = "a-key-of-the-tests-4711"
SCREEN = [[0.3, 0.05], [0.7, 0.06], [0.68, 0.2], [0.31, 0.21]]


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_floor_film(tmp_path_factory.mktemp("floor") / "floor.mp4", floor_picture())


class Saved:
    """Takes what is saved; refuses it as often as it is told."""

    def __init__(self, refusals: int = 0) -> None:
        self.refusals = refusals
        self.found: list[tuple[Clicks, CameraView]] = []

    def __call__(self, clicks: Clicks, view: CameraView) -> str:
        if self.refusals:
            self.refusals -= 1
            raise PersonError("the disk is full", "remove something")
        self.found.append((clicks, view))
        return "kept"


Ask = Callable[[aiohttp.ClientSession, str], Awaitable[None]]


def served(source: FrameSource, save: Saved, ask: Ask, camera: StageCamera | None = None) -> asyncio.Task[Any]:
    """Serve the page while `ask` asks it; return the server's task."""

    async def run() -> asyncio.Task[Any]:
        with socket.create_server(("127.0.0.1", 0)) as listening:
            page = MarksPage(FloorMarks(MARKS), camera or StageCamera(name="front"), source, save, "here")
            task = asyncio.create_task(page.run(listening, KEY))
            async with aiohttp.ClientSession() as client:
                await ask(client, f"http://127.0.0.1:{listening.getsockname()[1]}")
            if not save.found:
                task.cancel()
            await asyncio.wait((task,))
        return task

    source.start()
    try:
        return asyncio.run(asyncio.wait_for(run(), 60 * BUSY))
    finally:
        source.stop()


async def answer(page: aiohttp.ClientWebSocketResponse, **words: Any) -> dict[str, Any]:
    await page.send_json(words)
    told: dict[str, Any] = await page.receive_json()
    return told


def test_picture_check_and_save(film: Path) -> None:
    save = Saved(refusals=1)

    async def ask(client: aiohttp.ClientSession, at: str) -> None:
        async with client.ws_connect(at + WORD_PATH, protocols=("live.operator", f"live.key.{KEY}")) as page:
            places = mark_places()
            told = await answer(page, kind="check", places=places)
            assert "no picture yet" in told["problem"]
            told = await answer(page, kind="picture")
            assert (told["kind"], told["size"]) == ("picture", list(SIZE))
            picture = np.asarray(Image.open(io.BytesIO(await page.receive_bytes())))
            assert np.abs(picture.astype(int) - floor_picture()).mean() < 4.0
            number = told["number"]
            told = await answer(page, kind="picture", after=number, turn=90)
            assert told["number"] > number
            assert told["size"] == [SIZE[1], SIZE[0]]
            assert Image.open(io.BytesIO(await page.receive_bytes())).size == (SIZE[1], SIZE[0])

            told = await answer(page, kind="check", places=places, screen=SCREEN)
            assert (told["kind"], told["problem"]) == ("checked", "")
            assert told["camera_height"] == pytest.approx(2.0, abs=0.03)
            assert len(told["lines"]) == 7 + 7
            told = await answer(page, kind="check", places=[places[0], places[2], places[1], places[3]])
            assert told["kind"] == "checked"
            assert "convex shape in the picture" in told["problem"]
            assert told["remedy"]
            assert "lines" not in told
            assert "3 places" in (await answer(page, kind="check", places=places[:3]))["problem"]
            told = await answer(page, kind="check", places=[[1.0 - v, u] for u, v in places], turn=90)
            assert "on its side" in told["problem"]
            assert not save.found

            told = await answer(page, kind="save", places=places, screen=SCREEN[::-1])
            assert told["kind"] == "refused"
            assert "not in order" in told["problem"]
            told = await answer(page, kind="save", places=places, screen=SCREEN)
            assert told == {"kind": "refused", "problem": "the disk is full", "remedy": "remove something"}
            assert await answer(page, kind="save", places=places, screen=SCREEN) == {"kind": "saved", "words": "kept"}
            assert (await page.receive()).type is aiohttp.WSMsgType.CLOSE

    task = served(FrameSource(CameraAddress("film", str(film))), save, ask)
    assert task.result() == save.found[0]
    ((clicks, view),) = save.found
    assert clicks == Clicks(tuple((u, v) for u, v in mark_places()), tuple((u, v) for u, v in SCREEN))
    check_same_camera(view)


def test_only_the_page_with_the_key_is_answered(film: Path) -> None:
    async def ask(client: aiohttp.ClientSession, at: str) -> None:
        key, wrong = {"Authorization": f"Bearer {KEY}"}, {"Authorization": "Bearer wrong"}
        foreign = {"Origin": "http://evil.example", **key}
        for path, headers, status in (
            (ROOT, {}, 200), (f"{ROOT}/marks.js", {}, 200), ("/studio", {}, 404), (f"{ROOT}/../marks_page.py", {}, 404),
            ("/surface.json", {}, 401), ("/surface.json", wrong, 401), ("/surface.json", key, 200),
            ("/surface.json", foreign, 403), ("/surface.json", {"Host": "evil.example", **key}, 403),
            (ROOT, {"Host": "evil.example"}, 403), (WORD_PATH, {}, 401), (WORD_PATH, key, 400),
            (WORD_PATH, foreign, 403),
        ):  # fmt: skip
            async with client.get(at + path, headers=headers, allow_redirects=False) as told:
                assert told.status == status, (path, headers)
                assert "default-src 'none'" in told.headers["Content-Security-Policy"]
                assert "unsafe" not in told.headers["Content-Security-Policy"]
        async with client.get(f"{at}/", allow_redirects=False) as told:
            assert told.headers["Location"] == ROOT
        async with client.post(f"{at}{WORD_PATH}", headers=key) as told:
            assert told.status == 405
        for protocols, headers, status in (
            (("live.operator",), {}, 401), (("live.operator", "live.key.wrong"), {}, 401),
            (("live.operator", f"live.key.{KEY}"), {"Origin": "http://evil.example"}, 403),
        ):  # fmt: skip
            with pytest.raises(aiohttp.WSServerHandshakeError) as error:
                await client.ws_connect(at + WORD_PATH, protocols=protocols, headers=headers)
            assert error.value.status == status

    save = Saved()
    assert served(FrameSource(CameraAddress("film", str(film))), save, ask).cancelled()
    assert not save.found


def test_wrong_messages_are_refused_and_the_page_goes_on(film: Path) -> None:
    async def ask(client: aiohttp.ClientSession, at: str) -> None:
        async with client.ws_connect(at + WORD_PATH, protocols=("live.operator", f"live.key.{KEY}")) as page:
            good = {"kind": "check", "places": mark_places()}
            for wrong in (
                "", "{", "[" * 3000, "5", "{}", '{"kind": "stop"}', json.dumps(good | {"turn": 45}),
                json.dumps(good | {"x": 1}),
                json.dumps(good | {"places": [[0.5]] * 4}), json.dumps(good | {"places": [["a", 0.5]] * 4}),
                json.dumps(good | {"places": [[1e9, 0.5]] * 4}), '{"kind": "check", "places": [[NaN, 0.5]]}',
                json.dumps(good | {"places": [[0.5, 0.5]] * 33}), json.dumps(good | {"screen": SCREEN + SCREEN}),
                json.dumps({"kind": "picture", "after": -1}), json.dumps({"kind": "save", "places": "no"}),
            ):  # fmt: skip
                await page.send_str(wrong)
                told = await page.receive_json()
                assert (told["kind"], told["problem"][:14]) == ("refused", "wrong message:"), wrong
            await page.send_bytes(b"\0")
            assert (await page.receive_json())["kind"] == "refused"
            assert (await answer(page, kind="picture"))["kind"] == "picture"
            await page.receive_bytes()
            assert (await answer(page, **good))["problem"] == ""
            await page.send_str("x" * 9000)  # too long: this connection is closed, another one is not
            assert (await page.receive()).type is aiohttp.WSMsgType.CLOSE
        async with client.ws_connect(at + WORD_PATH, protocols=("live.operator", f"live.key.{KEY}")) as page:
            assert (await answer(page, **good))["problem"] == ""

    served(FrameSource(CameraAddress("film", str(film))), Saved(), ask)


def test_a_camera_without_pictures_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("live.bridges.camera.marks_page._WAIT_S", 0.2)

    async def ask(client: aiohttp.ClientSession, at: str) -> None:
        async with client.ws_connect(at + WORD_PATH, protocols=("live.operator", f"live.key.{KEY}")) as page:
            told = await answer(page, kind="picture")
            assert told["kind"] == "none"
            assert "No such file" in told["problem"]

    served(FrameSource(CameraAddress("film", str(tmp_path / "gone.mp4"))), Saved(), ask)


def test_marks_of_the_venue_are_shown_again(film: Path) -> None:
    rows = tuple((x, z, u, v) for (x, z), (u, v) in zip(MARKS, mark_places(), strict=True))
    moved = tuple((x + 1.0, z, u, v) for x, z, u, v in rows)
    for marks, places in ((rows, mark_places()), (moved, []), ((), [])):
        camera = StageCamera(name="side", marks=marks, turn_deg=180)
        source = FrameSource(CameraAddress("film", str(film)))
        facts = MarksPage(FloorMarks(MARKS), camera, source, Saved(), "here").facts()
        assert (facts["name"], facts["turn"], facts["places"]) == ("side", 180, places)


# -- in a browser ----------------------------------------------------------------------------------------------------


@contextmanager
def command(tmp_path: Path, *words: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """The running command and its page's link."""
    process = subprocess.Popen(
        [sys.executable, "-m", "live", "calibrate", "camera", "--port", "0", "--no-browser", *words], cwd=tmp_path,
        env={**os.environ, "LIVE_CONFIG_DIR": str(tmp_path / "settings")}, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    assert process.stderr is not None
    try:
        line = process.stderr.readline()
        assert line.startswith("click the marks: http://127.0.0.1:"), line + process.stderr.read()
        yield process, line.split()[-1]
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60 * BUSY)


class Page:
    """The page in a browser, and what went wrong in it."""

    def __init__(self, opened: Any, link: str) -> None:
        self.page = opened.new_context(viewport={"width": 1280, "height": 800}).new_page()
        self.page.set_default_timeout(30_000 * BUSY)
        self.problems: list[str] = []
        self.page.on("pageerror", lambda error: self.problems.append(str(error)))
        self.page.on("console", lambda message: message.type == "error" and self.problems.append(message.text))
        self.page.goto(link)
        self.page.get_by_text("Click mark 1 of 4").wait_for()

    def click(self, u: float, v: float) -> None:
        """Click in the picture, at shares of it."""
        box = self.page.locator("#picture").bounding_box()
        self.page.mouse.click(box["x"] + u * box["width"], box["y"] + v * box["height"])

    def says(self, words: str) -> None:
        """Wait until the page says that."""
        self.page.locator("#word", has_text=words).wait_for()


@pytest.mark.long
@pytest.mark.browser
@needs_browser
def test_marks_clicked_in_a_film_reproduce_the_camera_that_made_it(film: Path, tmp_path: Path) -> None:
    words = ("--venue", "hall", "--camera", str(film), "--marks", MARKS_TEXT, "--json")
    with command(tmp_path, *words) as (process, link), browser() as (opened, _):
        shown = Page(opened, link)
        page = shown.page
        assert "key" not in page.url, "the key leaves the address bar"
        assert page.get_by_role("button", name="Save").is_disabled()
        for number, (u, v) in enumerate(mark_places(), start=1):
            shown.says(f"Click mark {number} of 4")
            shown.click(u, v)
        shown.says("Does the green grid lie on the floor")
        assert page.locator("#grid line").count() == 7 + 7 + 1
        page.get_by_text("The camera stands 2", exact=False).wait_for()
        # the magnifier shows the mark at its middle
        middle = "[...document.querySelector('#glass').getContext('2d').getImageData(100, 100, 1, 1).data]"
        red, green, blue, _alpha = page.evaluate(middle)
        assert red > green + 60
        assert red > blue + 60
        page.get_by_text("The projected picture").click()
        for (u, v), corner in zip(SCREEN, ("upper left", "upper right", "lower right", "lower left"), strict=True):
            shown.says(f"Click the {corner} corner")
            assert page.get_by_role("button", name="Save").is_disabled() == (corner != "upper left")
            shown.click(u, v)
        shown.says("Does the green grid")
        page.get_by_role("button", name="Save").click()
        shown.says("You can close this page")
        assert process.wait(60 * BUSY) == 0
        assert process.stdout is not None
        told = json.loads(process.stdout.read())
        assert not shown.problems
    check_venue(tmp_path, told)


def check_venue(tmp_path: Path, told: dict[str, Any]) -> None:
    """The venue's file has the camera that made the film; clicks are whole pixels of the page."""
    assert told["file"] == str(tmp_path / "settings" / "venues" / "hall.toml")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LIVE_CONFIG_DIR", str(tmp_path / "settings"))
        view = venue_view("hall")
    off = VIEW.on_floor(mark_places()) - view.on_floor(mark_places())
    assert np.linalg.norm(off, axis=1).max() < 0.02
    np.testing.assert_allclose(view.position, VIEW.position, atol=0.1)
    assert np.abs(np.array(told["screen"]) - SCREEN).max() < 1.5 / 800


@pytest.mark.long
@pytest.mark.browser
@needs_browser
def test_bad_marks_are_explained_dragged_right_and_nudged_by_keys(film: Path, tmp_path: Path) -> None:
    with command(tmp_path, "--camera", str(film), "--marks", MARKS_TEXT) as (process, link), browser() as (opened, _):
        shown = Page(opened, link)
        page, places = shown.page, mark_places()
        for index in (0, 2, 1, 3):  # in a wrong order
            shown.click(*places[index])
        shown.says("not the corners of a convex shape in the picture")
        assert page.get_by_role("button", name="Save").is_disabled()
        assert page.locator("#grid line").count() == 0
        for index, elsewhere in ((1, (0.5, 0.9)), (2, places[2]), (1, places[1])):
            mark = page.get_by_role("button", name=f"Mark {index + 1}:").bounding_box()
            page.mouse.move(mark["x"] + mark["width"] / 2, mark["y"] + mark["height"] / 2)
            page.mouse.down()
            box = page.locator("#picture").bounding_box()
            page.mouse.move(box["x"] + elsewhere[0] * box["width"], box["y"] + elsewhere[1] * box["height"], steps=4)
            page.mouse.up()
        shown.says("Does the green grid")

        mark = page.get_by_role("button", name="Mark 2:")
        left, top = (page.get_by_label(f"Mark 2: per cent from the {side}") for side in ("left", "top"))
        before = float(left.input_value()), float(top.input_value())
        mark.focus()
        for _ in range(4):
            page.keyboard.press("ArrowRight")
        page.keyboard.press("Shift+ArrowUp")
        after = float(left.input_value()), float(top.input_value())
        assert after[0] - before[0] == pytest.approx(4 * 0.5 / SIZE[0] * 100, abs=0.011)
        assert after[1] - before[1] == pytest.approx(-10 / SIZE[1] * 100, abs=0.011)
        top.fill(str(before[1]))
        top.press("Enter")
        left.fill("120")
        left.press("Enter")
        assert mark.get_attribute("aria-label").startswith("Mark 2: 100.00 % from the left"), "kept in the picture"
        page.get_by_role("button", name="Begin again").click()
        shown.says("Click mark 1 of 4")

        for index, (u, v) in enumerate(places):  # by keyboard alone
            page.get_by_role("button", name=f"Place mark {index + 1} with the keys").press("Enter")
            assert page.evaluate("document.activeElement.ariaLabel").startswith(
                f"Mark {index + 1}: 50.00 % from the left"
            )
            page.get_by_label(f"Mark {index + 1}: per cent from the left").fill(f"{100 * u:.2f}")
            page.get_by_label(f"Mark {index + 1}: per cent from the top").fill(f"{100 * v:.2f}")
            page.keyboard.press("Tab")
        shown.says("Does the green grid")
        page.get_by_role("button", name="Turn by 90°").click()
        shown.says("Click mark 1 of 4")
        page.wait_for_function("document.querySelector('#picture').naturalWidth === 540")
        for u, v in places:
            shown.click(v, 1.0 - u)  # the picture was turned counter-clockwise
        shown.says("the picture is on its side: turn it (--turn-deg 0)")
        assert not shown.problems
        assert process.poll() is None, "nothing was saved"
    assert not (tmp_path / "settings" / "venues").exists()


@pytest.mark.long
@pytest.mark.browser
@needs_browser
def test_the_page_asks_for_the_link_and_says_when_the_program_ends(film: Path, tmp_path: Path) -> None:
    with browser() as (opened, _):
        with command(tmp_path, "--camera", str(film), "--marks", MARKS_TEXT) as (_process, link):
            page = opened.new_context().new_page()
            page.set_default_timeout(30_000 * BUSY)
            page.goto(link.partition("#")[0])
            page.get_by_label("This page needs the link").fill("wrong-key")
            page.get_by_role("button", name="Open").click()
            page.get_by_label("This page needs the link").wait_for()
            page.get_by_label("This page needs the link").fill(link)
            page.get_by_role("button", name="Open").click()
            page.get_by_text("Click mark 1 of 4").wait_for()
        page.get_by_text("Is the command still running?").wait_for()


@pytest.mark.long
@pytest.mark.browser
@needs_browser
@pytest.mark.skipif(not AXE.is_file(), reason="needs the packages of studio/ (make test installs them where npm is)")
@pytest.mark.parametrize("size", [(390, 844), (1280, 800)])
def test_axe_finds_nothing(film: Path, tmp_path: Path, size: tuple[int, int]) -> None:
    words = ("--camera", str(film), "--marks", MARKS_TEXT)
    with command(tmp_path, *words) as (_process, link), browser() as (opened, _):
        shown = Page(opened, link)
        page = shown.page
        page.set_viewport_size({"width": size[0], "height": size[1]})
        for u, v in mark_places():
            shown.click(u, v)
        shown.says("Does the green grid")
        page.get_by_text("The projected picture").click()
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        page.evaluate(AXE.read_text("utf-8"))
        found = page.evaluate("axe.run(document, { resultTypes: ['violations'] })")["violations"]
        assert [(one["id"], [node["html"][:120] for node in one["nodes"]]) for one in found] == []
