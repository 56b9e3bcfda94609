"""The studio's page: served whole under its policy, and its pages for running a show, in a browser."""

import gzip

import aiohttp
import pytest

from live.control.web.studio_files import FOLDER, StudioFiles
from tests.control.web.test_web_server import KEY, LEVEL, PageServer, run
from tests.end_to_end.browser import browser, needs_browser

MOST_BYTES = 250_000
"""Maximum compressed size of the page."""


@pytest.mark.long
def test_files_come_without_a_key_and_under_a_policy_that_runs_only_them() -> None:
    async def what(client: aiohttp.ClientSession, page: PageServer) -> None:
        for path in ("/studio", "/studio/app.js", "/studio/app.css"):
            async with client.get(page.at + path) as answer:
                policy = answer.headers["Content-Security-Policy"]
                assert answer.status == 200
                assert "script-src 'self'" in policy
                assert "unsafe" not in policy
                tag = answer.headers["ETag"]
            async with client.get(page.at + path, headers={"If-None-Match": tag}) as answer:
                assert answer.status == 304
        for path in ("/studio/", "/studio/..%2fweb_server.py", "/studio/nothing.js", "/studio/index.html"):
            async with client.get(page.at + path) as answer:
                assert answer.status == 404
        for headers in ({"Origin": "http://evil.example"}, {"Host": "evil.example"}):
            async with client.get(page.at + "/studio", headers=headers) as answer:
                assert answer.status == 403

    run(PageServer(), what)


def test_page_is_small_and_needs_no_other_server() -> None:
    files = {file.name: file.read_bytes() for file in FOLDER.iterdir()}
    assert sum(len(gzip.compress(data, 9)) for name, data in files.items() if name != "stage3d.js") < MOST_BYTES
    assert "/studio" in StudioFiles()
    assert b"<script>" not in files["index.html"]
    assert b"https://" not in files["index.html"]


@pytest.mark.long
@pytest.mark.browser
@needs_browser
def test_roles_set_values_and_learn_midi() -> None:
    with PageServer() as page, browser() as (open_socket, _):
        view = open_socket.new_page(viewport={"width": 1280, "height": 800})
        problems: list[str] = []
        view.on("pageerror", lambda error: problems.append(str(error)))
        page.tell(status_cue="dawn", light_level=1.0)
        view.goto(f"{page.at}/studio#key={KEY}")
        view.get_by_role("button", name="Show", exact=True).click()
        view.get_by_role("region", name="Standby").get_by_role("heading", name="dawn").wait_for()
        view.get_by_role("region", name="Standby").get_by_role("button", name="GO").click()
        assert page.heard() == ("/dance/go",)
        view.get_by_role("button", name="Light", exact=True).click()
        level = view.get_by_role("slider", name="level").first
        level.focus()
        view.keyboard.press("ArrowRight")
        address, value = page.heard()
        assert address == LEVEL
        assert 1.0 < value < 1.1
        level.click(button="right")
        view.get_by_role("menuitem", name="Learn MIDI").click()
        assert page.heard() == ("/dance/midi/learn", LEVEL)
        view.get_by_text("key colour", exact=True).click()
        view.get_by_role("button", name="key colour: red").click()
        address, *colour = page.heard()
        assert address == "/dance/light/key/colour"
        assert colour == pytest.approx([1.0, 0.068, 0.023], abs=0.01)
        view.get_by_role("button", name="Everything", exact=True).click()
        view.get_by_label("Find a control").fill("kick")
        view.get_by_role("button", name="kick").click()
        assert page.heard() == ("/dance/step", "kick")
        assert problems == []
