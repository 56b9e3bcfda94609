"""Pads for improvising and the phones, in a browser with a real show and a real preview."""

import re
import socket
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from live.control.events.event import ControlEvent
from live.control.osc.osc_codec import decode
from live.control.registry.registry import REGISTRY
from tests.app.services.test_document_service import PATCH
from tests.app.services.test_studio_pages import KEY, Studio
from tests.control.waiting import BUSY
from tests.end_to_end.browser import browser, needs_browser
from tests.show.patch.edited_night import write_patch_folder

pytestmark = [needs_browser, pytest.mark.browser, pytest.mark.long]
TIMEOUT = 60_000 * BUSY
COUNTED_BEATS = """() => {
  const shown = document.querySelector(".countin:not(.measures) b");
  return shown ? Number(shown.textContent) : 0;
}"""


@pytest.fixture
def port() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as made:
        made.bind(("127.0.0.1", 0))
        made.settimeout(30.0 * BUSY)
        yield made


@pytest.fixture
def show(tmp_path: Path, port: socket.socket) -> Iterator[Studio]:
    made = Studio(write_patch_folder(tmp_path, PATCH), port.getsockname())
    yield made
    made.stop()


@pytest.fixture
def page(show: Studio) -> Iterator[Any]:
    with browser() as (opened, _):
        made = opened.new_page(viewport={"width": 1440, "height": 900})
        made.set_default_timeout(TIMEOUT)
        errors: list[str] = []
        made.on("pageerror", lambda error: errors.append(str(error)))
        made.goto(f"http://127.0.0.1:{show.web.port}/studio#key={KEY}")
        yield made
        assert not errors


def received(port: socket.socket, show: Studio) -> tuple[Any, ...]:
    """Return the page's next command, which the show gets, too."""
    (message,) = decode(port.recv(4096))
    made = REGISTRY.call(message.address, list(message.arguments), show.clock.now(), "osc")
    assert isinstance(made, ControlEvent), made
    show.inbox.put(made)
    return message.address, *message.arguments


def until(fits: Any, page: Any) -> None:
    deadline = time.monotonic() + 60.0 * BUSY
    while not fits():
        assert time.monotonic() < deadline, "waited in vain"
        page.wait_for_timeout(20)


def play(page: Any, view: str = "") -> Any:
    """Open the pads, on the page `view` of them; return their region."""
    page.get_by_role("navigation", name="Views").get_by_role("button", name="Play").click()
    region = page.get_by_role("region", name="Pads")
    if view:
        region.get_by_role("button", name=view, exact=True).click()
    return region


def test_a_pad_is_launched_for_a_group_and_danced(show: Studio, port: socket.socket, page: Any) -> None:
    play(page)
    page.get_by_role("button", name="side step ember").click()
    assert received(port, show) == ("/dance/launch", "step side step", "ember", "measure", 4.0, "stop")
    page.get_by_role("button", name=re.compile("side step ember, (in|runs)")).wait_for()
    until(lambda: set(show.names()) == {"side step"}, page)  # tide dances it anyway
    page.get_by_role("button", name="side step ember, runs").wait_for()
    page.get_by_role("button", name="Stop ember").click()
    assert received(port, show) == ("/dance/launch/stop", "ember")
    until(lambda: set(show.names()) == {"groove", "side step"}, page)
    page.get_by_role("button", name="groove everybody").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("2")  # the second pad, for ember
    assert received(port, show)[1:3] == ("step side step", "ember")
    page.get_by_role("button", name="Keep", exact=True).click()
    assert received(port, show)[:2] == ("/dance/document/keep/measures", 16)
    until(lambda: "take" in show.path.read_text(), page)


def test_after_an_element_a_formation_is_suggested_and_launched(show: Studio, port: socket.socket, page: Any) -> None:
    play(page)
    made = REGISTRY.call("/dance/launch", ("element spread", "*", "now", 1), show.clock.now(), "grid")
    assert isinstance(made, ControlEvent)
    show.inbox.put(made)
    strip = page.get_by_role("group", name="What could come next")
    strip.get_by_text("after spread, next:").wait_for()
    best = show.next.facts()["pads"][0]
    strip.get_by_role("button").first.click()
    assert received(port, show) == ("/dance/launch", best["pad"], "*", "measure", float(best["measures"]))
    until(lambda: "motion *" in show.show.launcher.running, page)
    strip.wait_for(state="hidden")


def test_launches_on_the_beat_and_the_section_are_counted_in(show: Studio, port: socket.socket, page: Any) -> None:
    """What another page or controller launches is seen here, too."""
    region = play(page, "Formations")
    region.get_by_role("button", name="Section", exact=True).click()
    page.get_by_role("button", name="circle everybody").click()
    assert received(port, show)[:4] == ("/dance/launch", "formation circle", "*", "section")
    page.get_by_role("button", name=re.compile(r"circle everybody, in \d+ beats?")).wait_for()
    page.get_by_role("timer", name="Begins next: circle, everybody").wait_for()
    counted: list[int] = []

    def has_counted() -> bool:
        number = page.evaluate(COUNTED_BEATS)
        if number and counted[-1:] != [number]:
            counted.append(number)
        return page.get_by_role("button", name="circle everybody, runs").count() > 0

    until(has_counted, page)
    assert counted == sorted(counted, reverse=True)
    assert len(counted) >= 2  # a busy machine misses some
    assert counted[0] <= 8
    begun = next(iter(show.show.launcher.running.values()))
    assert begun.due % 32 == 0  # without sections: a phrase of eight measures
    region.get_by_role("button", name="Elements", exact=True).click()
    region.get_by_role("button", name="Beat", exact=True).click()
    page.get_by_role("button", name="spread tide").click()
    assert received(port, show)[3] == "beat"
    page.get_by_role("button", name="spread tide, runs").wait_for()
    assert show.show.launcher.running["elements tide"].due % 1 == 0
    made = REGISTRY.call("/dance/launch", ("element wander", "ember", "now"), show.clock.now(), "grid")
    assert isinstance(made, ControlEvent)
    show.inbox.put(made)
    page.get_by_role("button", name="wander ember, runs").wait_for()
    page.get_by_role("button", name="Stop all").click()
    assert received(port, show) == ("/dance/launch/stop", "*")
    page.get_by_role("button", name="wander ember", exact=True).wait_for()
    assert not show.show.launcher.running


def test_kept_pads_follow_each_other(show: Studio, port: socket.socket, page: Any) -> None:
    region = play(page, "Elements")
    page.get_by_label("For how many measures").select_option("1")
    page.get_by_label("What follows", exact=True).select_option("next")
    page.get_by_role("button", name="Keep spread among mine").click()
    page.get_by_role("button", name="Keep wander among mine").click()
    until(lambda: show.path.read_text().count("[[pad]]") == 2, page)
    region.get_by_role("button", name="Mine", exact=True).click()
    page.get_by_label("What follows wander").select_option("stop")
    page.get_by_label("Measures of wander").fill("2")
    page.get_by_label("Measures of wander").press("Enter")
    until(lambda: "measures = 2" in show.path.read_text().split("[[pad]]")[2], page)
    page.get_by_role("button", name="spread ember").click()
    assert received(port, show) == ("/dance/launch", "own spread", "ember", "measure")
    page.get_by_role("button", name="spread ember, runs").wait_for()
    page.get_by_role("button", name=re.compile("wander ember, in")).wait_for()
    page.get_by_role("button", name="wander ember, runs").wait_for()
    page.get_by_role("button", name="wander ember", exact=True).wait_for()
    assert show.show.launcher.facts() == {"waiting": {}, "running": {}, "launched": 2}


def test_show_has_the_invitation_for_phones_and_asks_for_a_new_one(
    show: Studio, port: socket.socket, page: Any
) -> None:
    page.get_by_role("navigation", name="Views").get_by_role("button", name="Show").click()
    page.get_by_role("navigation", name="Roles").get_by_role("button", name="Phones").click()
    page.get_by_text("No audience can join").wait_for()
    links = ["http://192.168.1.5:8020/#i.first", "http://192.168.1.5:8020/#i.second"]
    show.web.join_link = lambda: links[0]
    page.get_by_role("link", name=links[0]).wait_for()
    page.get_by_role("button", name="New invitation").click()
    assert received(port, show) == ("/dance/audience/invite",)
    until(lambda: show.show.audience.invitation == 2, page)
    links.pop(0)
    page.get_by_role("link", name=links[0]).wait_for()
    page.get_by_role("switch", name="tally").or_(page.get_by_text("tally")).first.wait_for()
    vote = page.get_by_role("region", name="Vote")
    for name in ("side step", "walk"):
        vote.get_by_role("switch", name=name, exact=True).click()
    vote.get_by_role("button", name="Let them vote").click()
    assert received(port, show) == ("/dance/audience/vote", "step", "side step", "walk")
    until(lambda: show.show.audience.vote is not None, page)
    show.web.join_link = lambda: "javascript:alert(1)"
    page.get_by_text("javascript:alert(1)").wait_for()
    assert page.get_by_text("javascript:alert(1)").get_attribute("href") is None
