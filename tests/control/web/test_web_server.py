"""Tests of the operator's page: access, values sent to and from the show, and a browser that uses it."""

import asyncio
import contextlib
import json
import socket

import aiohttp
import numpy as np
import pytest
from pythonosc.osc_message import OscMessage

from live.app.services.http_services import HttpService
from live.clock.time_source import SystemClock
from live.control.registry.registry import REGISTRY
from live.control.web.web_server import PAGE, _surface_json
from tests.control.waiting import wait_for
from tests.end_to_end.browser import browser, needs_browser

LEVEL = "/dance/light/level"
KEY = "a-key-of-the-tests-4711"
BEARER = {"Authorization": f"Bearer {KEY}"}


class PageServer:
    """A server with a socket in place of the show's OSC port."""

    def __init__(self):
        self.show = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.show.bind(("127.0.0.1", 0))
        self.show.settimeout(20.0)
        plan = {
            "key": KEY, "hosts": [], "osc": self.show.getsockname(), "name": "a show", "half": (5.0, 3.0),
            "names": {"/dance/step": ["kick", "<b>turn</b>"]},
        }  # fmt: skip
        self.part = HttpService(("127.0.0.1", 0), "--web", "live.control.web.web_server", lambda: plan, SystemClock())

    def __enter__(self):
        self.part.start()
        self.at = f"http://127.0.0.1:{self.part.port}"
        return self

    def __exit__(self, *_):
        self.part.stop()
        self.show.close()

    def heard(self):
        message = OscMessage(self.show.recv(2000))
        return (message.address, *message.params)

    def tell(self, **values):
        """Publishes values of the show, keyed by the end of their address."""
        self.part.publish({f"/dance/{name.replace('_', '/')}": (("", (value,)),) for name, value in values.items()})
        self.part.frame()


def run(page, what):
    async def all_of_it():
        async with aiohttp.ClientSession() as client:
            await what(client, page)

    with page:
        asyncio.run(asyncio.wait_for(all_of_it(), 60.0))


def open_socket(client, page):
    """The WebSocket, opened as the page opens it."""
    return client.ws_connect(page.at + "/ws", protocols=("live.operator", f"live.key.{KEY}"))


async def status(client, page, path, **headers):
    async with client.get(page.at + path, headers=headers) as answer:
        return answer.status, await answer.text()


@pytest.mark.long
def test_page_is_self_contained_and_foreign_origins_are_refused():
    async def what(client, page):
        code, text = await status(client, page, "/")
        assert (code, text) == (200, PAGE.read_text(encoding="utf-8"))
        assert len(text) < 50_000
        assert "http://" not in text
        assert "https://" not in text
        for path in ("/", "/surface.json", "/nothing"):
            async with client.get(page.at + path) as answer:
                policy = answer.headers["Content-Security-Policy"]
                assert "default-src 'none'" in policy
                assert "frame-ancestors 'none'" in policy
                assert "unsafe" not in policy
                for name, value in (
                    ("X-Frame-Options", "DENY"), ("X-Content-Type-Options", "nosniff"),
                    ("Referrer-Policy", "no-referrer"), ("Cache-Control", "no-store"),
                ):  # fmt: skip
                    assert answer.headers[name] == value
        _, told = await status(client, page, "/surface.json", **BEARER)
        steps = next(p for p in json.loads(told)["pages"] if p["title"] == "step")
        assert [widget["values"] for widget in steps["widgets"]] == [["kick"], ["<b>turn</b>"]]
        for headers in ({"Origin": "http://evil.example"}, {"Host": "evil.example"}):
            for path in ("/", "/surface.json", "/ws"):
                assert (await status(client, page, path, **headers))[0] == 403
        assert (await status(client, page, "/../web_server.py"))[0] == 404
        with pytest.raises(aiohttp.WSServerHandshakeError):
            await client.ws_connect(page.at + "/ws", headers={"Origin": "http://evil.example"})

    run(PageServer(), what)


@pytest.mark.long
def test_access_requires_the_key_of_the_link():
    async def what(client, page):
        wrong = [
            (),
            ("live.operator",),
            (f"live.key.{KEY}",),
            ("live.operator", "live.key.wrong"),
            ("live.operator", KEY),
        ]
        for protocols in wrong:
            with pytest.raises(aiohttp.WSServerHandshakeError) as error:
                await client.ws_connect(page.at + "/ws?key=" + KEY, protocols=protocols)
            assert error.value.status == 401
        assert (await status(client, page, "/surface.json"))[0] == 401
        assert (await status(client, page, "/ws", **BEARER))[0] == 400
        async with open_socket(client, page) as ws:
            assert ws.protocol == "live.operator", "the key is not said back"
            await ws.send_str(json.dumps({"address": "/dance/go", "values": []}))
            assert page.heard() == ("/dance/go",)
        async with client.ws_connect(page.at + "/ws", headers=BEARER) as ws:  # a program
            await ws.send_str(json.dumps({"address": "/dance/back", "values": []}))
            assert page.heard() == ("/dance/back",)

    run(PageServer(), what)


@pytest.mark.long
def test_values_are_sent_both_ways_with_last_value_shown():
    async def what(client, page):
        page.tell(light_level=1.25, status_bpm=128.0)
        async with open_socket(client, page) as ws:
            told = {}
            while len(told) < 2:
                told |= json.loads((await ws.receive(timeout=20.0)).data)["values"]
            assert told == {LEVEL: [1.25], "/dance/status/bpm": [128.0]}
            await ws.send_str(json.dumps({"address": LEVEL, "values": [0.5]}))
            assert page.heard() == (LEVEL, 0.5)
            page.tell(light_level=0.5)
            assert json.loads((await ws.receive(timeout=20.0)).data) == {"values": {LEVEL: [0.5]}}

    run(PageServer(), what)


def test_pages_are_told_how_phones_join_and_when_that_changes():
    async def what(client, page):
        page.part._helper.send(["join", "http://a/#i.1"])
        page.tell(light_level=1.25)
        async with open_socket(client, page) as ws:
            told = {}
            while "join" not in told:
                told |= json.loads((await ws.receive(timeout=20.0)).data)
            assert told["join"] == "http://a/#i.1"
            page.part._helper.send(["join", ""])
            while told["join"]:
                told |= json.loads((await ws.receive(timeout=20.0)).data)

    run(PageServer(), what)


@pytest.mark.long
def test_performer_values_are_sent_per_performer():
    async def what(client, page):
        page.part.publish({"/dance/mocap/mirrored": (("anna", (True,)), ("ben", (False,)), ("two words", (True,)))})
        page.part.frame()
        told: dict = {}
        async with open_socket(client, page) as ws:
            while "/dance/mocap/ben/mirrored" not in told:
                told |= json.loads((await ws.receive(timeout=20.0)).data)["values"]
        assert told == {"/dance/mocap/anna/mirrored": [True], "/dance/mocap/ben/mirrored": [False]}

    run(PageServer(), what)


def test_controls_of_named_performers_have_their_words():
    facts = {"name": "a show", "names": {"/dance/mocap/shown": ["anna"]}, "half": (5.0, 3.0)}
    widgets = [widget for page in _surface_json(facts)["pages"] for widget in page["widgets"]]
    words = {widget["address"]: widget["words"] for widget in widgets}
    assert words["/dance/mocap/anna/shown"] == REGISTRY.find("/dance/mocap/shown").description
    assert all(words.values())


HOSTILE = (
    "", "{", "[]", "null", "5", '"x"', "[" * 1000, '{"address": 5, "values": []}', '{"address": "/dance/go"}',
    '{"address": "/dance/go", "values": 3}', '{"address": "/dance/go", "values": [1, 2, 3, 4, 5, 6, 7, 8, 9]}',
    '{"address": "/dance/light/level", "values": [NaN]}', '{"address": "/dance/light/level", "values": [1e999]}',
    '{"address": "/dance/light/level", "values": ["1"]}', '{"address": "/dance/light/level", "values": [null]}',
    '{"address": "/dance/light/level", "values": [[1]]}', '{"address": "/dance/light/level", "values": [{"a": 1}]}',
    '{"address": "/dance/light/level", "values": [' + "9" * 400 + "]}",
    '{"address": "/dance/*", "values": [1]}', '{"address": "/nobody", "values": []}', "\ud7ff", "\x00",
)  # fmt: skip
"""What is no message of the page."""


@pytest.mark.long
def test_hostile_messages_are_refused_with_text():
    chance = np.random.default_rng(5)
    good = json.dumps({"address": LEVEL, "values": [0.75]})
    mutated = []
    for _ in range(100):
        letters = list(good)
        for _ in range(int(chance.integers(1, 4))):
            letters[int(chance.integers(len(letters)))] = chr(int(chance.integers(32, 127)))
        mutated.append("".join(letters))

    async def what(client, page):
        async with open_socket(client, page) as ws:
            for text in HOSTILE:
                await ws.send_str(text)
                assert json.loads((await ws.receive(timeout=20.0)).data)["refused"]
            await ws.send_bytes(b"\x00\xff")
            assert json.loads((await ws.receive(timeout=20.0)).data)["refused"]
            for text in mutated:
                await ws.send_str(text)
            await ws.send_str(good)
            for _ in range(len(mutated) + 1):  # those that are still right go to the show, and this one does
                if page.heard() == (LEVEL, 0.75):
                    break
        async with open_socket(client, page) as ws:
            await ws.send_str("x" * 5000)
            assert (await ws.receive(timeout=20.0)).type is aiohttp.WSMsgType.CLOSE
        async with open_socket(client, page) as ws:
            for _ in range(400):
                await ws.send_str(good)
            while "too many" not in (await ws.receive(timeout=20.0)).data:
                pass
        assert wait_for(lambda: page.part.frame() or page.part.status().get("refused", 0) > len(HOSTILE) + 100, 10.0)

    run(PageServer(), what)


@pytest.mark.browser
@needs_browser
def test_browser_shows_and_sets_show_values():
    with PageServer() as page, browser() as (open_socket, _):
        view = open_socket.new_page(viewport={"width": 900, "height": 700})
        problems = []
        view.on("pageerror", lambda error: problems.append(str(error)))
        page.tell(status_measure=7, status_beat=3, status_bpm=96.0, light_level=1.0)
        view.goto(f"{page.at}/#key={KEY}")
        view.get_by_text("7.3").wait_for()
        view.get_by_role("button", name="GO", exact=True).click()
        assert page.heard() == ("/dance/go",)
        view.get_by_role("button", name="Blackout").click()
        assert page.heard()[:2] == ("/dance/blackout", 1)
        page.tell(blackout=True)
        view.locator("#now button[aria-pressed=true]", has_text="Blackout").wait_for()
        view.get_by_role("tab", name="light 1", exact=True).click()
        slider = view.get_by_role("slider", name="level", exact=True)
        slider.focus()
        view.keyboard.press("ArrowRight")
        address, value = page.heard()
        assert address == LEVEL
        assert 1.0 < value < 1.1
        view.get_by_role("tab", name="stage", exact=True).click()
        box = view.locator("[data-address='/dance/attract'] div").bounding_box()
        view.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
        view.mouse.down()
        view.mouse.move(box["x"] + 0.75 * box["width"], box["y"] + 0.9 * box["height"], steps=4)
        view.mouse.up()
        address, x, z = page.heard()
        assert address == "/dance/attract"
        assert (x, z) == pytest.approx((2.5, 2.4), abs=0.15), "once, where the finger left; the audience is below"
        page.show.setblocking(False)
        with contextlib.suppress(BlockingIOError):
            pytest.fail(f"more was sent: {page.heard()}")
        view.get_by_role("tab", name="step", exact=True).click()
        assert view.get_by_text("<b>turn</b>").is_visible(), "names are shown as they are written"
        assert problems == []


@pytest.mark.long
def test_controls_follow_an_edited_show():
    """The pads' ends and the buttons of a page that is loaded after the edit."""

    async def what(client, page):
        facts = {"name": "another", "half": (8.0, 2.5), "names": {"/dance/step": ["bow"]}}
        page.part._helper.send(["surface", facts])
        while True:  # until the process has read it; the test has a time limit
            _, told = await status(client, page, "/surface.json", **BEARER)
            found = json.loads(told)
            if found["name"] == "another":
                break
        widgets = [widget for one in found["pages"] for widget in one["widgets"]]
        assert [widget["values"] for widget in widgets if widget["address"] == "/dance/step"] == [["bow"]]
        pads = [widget for widget in widgets if widget["address"] == "/dance/attract" and widget["kind"] == "pad"]
        assert [(pad["minimum"], pad["maximum"]) for pad in pads] == [([-8.0, -2.5], [8.0, 2.5])]

    run(PageServer(), what)
